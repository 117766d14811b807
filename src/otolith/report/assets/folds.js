// A link into a folded part opens it; a printed page shows all parts.
"use strict";
(() => {
  const open = () => {
    const key = decodeURIComponent(location.hash.slice(1));
    for (let at = document.getElementById(key); at; at = at.parentElement) if (at.matches("details")) at.open = true;
    document.getElementById(key)?.scrollIntoView();
  };
  addEventListener("hashchange", open);
  if (location.hash) open();
  addEventListener("beforeprint", () => { for (const fold of document.querySelectorAll("details")) fold.open = true; });
})();
