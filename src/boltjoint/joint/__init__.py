"""Joints: contact points with their modal rows and friction elements, node to node or reduced."""
