// What the page has of all this starts with it.
if (at("curves")) startResponses();
if (at("view-open")) at("view-open").addEventListener("click", openView);
