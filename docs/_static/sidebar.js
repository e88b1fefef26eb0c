// The parts of the sidebar open and close; without a script all are open.
document.addEventListener("DOMContentLoaded", () => {
  for (const tree of document.querySelectorAll(".sidebar-tree")) {
    tree.classList.add("closable");
    const current = tree.querySelector("p.caption + ul.current") ?? tree.querySelector("p.caption + ul");
    for (const caption of tree.querySelectorAll("p.caption")) {
      const set = (open) => caption.setAttribute("aria-expanded", open);
      const turn = () => set(caption.getAttribute("aria-expanded") !== "true");
      caption.tabIndex = 0;
      caption.role = "button";
      set(caption.nextElementSibling === current);
      caption.addEventListener("click", turn);
      caption.addEventListener("keydown", (event) => {
        if (event.key === "Enter" || event.key === " ") {
          event.preventDefault();
          turn();
        }
      });
    }
  }
});
