// What viser's page lacks. First, names for those who hear the page instead of seeing it. Viser writes the words beside a control
// but ties them to few of its controls, and gives pictures none; this adds what is missing, also
// to whatever is drawn later. If viser comes to do so itself, nothing here finds anything to do.
(() => {
  if (window.ao2vizNames) return; // A page that connects anew is sent this again.
  window.ao2vizNames = true;
  const name = (element, words) => {
    if (words && !element.getAttribute("aria-label")) element.setAttribute("aria-label", words);
  };
  const tidy = () => {
    for (const label of document.querySelectorAll("label[for]")) {
      const row = label.closest("div:has(input, [role=slider])");
      for (const control of row?.querySelectorAll("input, [role=slider]") ?? []) {
        name(control, label.textContent.trim());
      }
    }
    for (const bar of document.querySelectorAll("[role=progressbar]")) name(bar, "Progress");
    for (const picture of document.querySelectorAll("img:not([alt])")) {
      picture.alt = "The environment at this step";
    }
    for (const [icon, words] of [["list-search", "Commands"], ["adjustments", "Page options"]]) {
      for (const button of document.querySelectorAll(`button:has(svg.tabler-icon-${icon})`)) {
        if (!button.textContent.trim()) name(button, words);
      }
    }
    // What can only be scrolled has to be reachable by key.
    for (const area of document.querySelectorAll("[data-scrollarea-viewport]:not([role=listbox] *)")) {
      const holds = area.querySelector("button:enabled, input:enabled, [tabindex='0']");
      if (holds) area.removeAttribute("tabindex");
      else area.tabIndex = 0;
    }
  };
  // Keys of the page do nothing while somebody types, but Escape leaves a dialog all the same.
  document.addEventListener("keydown", (event) => {
    const field = event.target;
    if (event.key !== "Escape" || !field.matches("[role=dialog] :is(input, textarea)")) return;
    if (field.getAttribute("aria-expanded") === "true") return; // It closes its list first.
    const buttons = field.closest("[role=dialog]").querySelectorAll("button");
    [...buttons].find((button) => button.textContent.trim() === "Close")?.click();
  }, { capture: true });
  // A key may ask for what stands in a tab that is not open.
  window.ao2vizShowTab = (words) => {
    for (const tab of document.querySelectorAll("[role=tab]")) {
      if (tab.textContent.trim() !== words || tab.getAttribute("aria-selected") === "true") continue;
      tab.focus();
      // Viser's tabs are opened by pointer, as they can be dragged, or by key.
      tab.dispatchEvent(new KeyboardEvent("keydown", { key: "Enter", bubbles: true }));
    }
  };
  let waits = false;
  new MutationObserver(() => {
    if (waits) return;
    waits = true;
    setTimeout(() => {
      waits = false;
      tidy();
    }, 200);
  }).observe(document.body, { childList: true, subtree: true });
  tidy();
})();
