"use strict";
// details that are folded would not be printed
window.addEventListener("beforeprint", () => {
  document.querySelectorAll("main details:not([open])").forEach((each) => {
    each.dataset.folded = "yes";
    each.open = true;
  });
});
window.addEventListener("afterprint", () => {
  document.querySelectorAll("main details[data-folded]").forEach((each) => {
    delete each.dataset.folded;
    each.open = false;
  });
});
// a link to what is folded opens it
function unfold() {
  const target = document.getElementById(decodeURIComponent(location.hash.slice(1)));
  if (!target) return;
  const own = target.querySelector(":scope > details");
  if (own) own.open = true;
  for (let each = target; each; each = each.parentElement) {
    if (each.tagName === "DETAILS") each.open = true;
  }
  target.scrollIntoView();
}
window.addEventListener("hashchange", unfold);
unfold();
