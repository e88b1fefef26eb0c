// The pictures of a run in tabs: each is fetched, and drawn by the server, when its tab is opened.

import { CYCLES } from "./answer.js";
import { Curves } from "./curves.js";
import { byId, element } from "./page.js";
import { States } from "./states.js";
import { Viewer } from "./viewer.js";

export class Pictures {
  constructor() {
    this.viewer = new Viewer(byId("picture"), "Picture of the answer");
    this.states = new States(this.viewer);
    this.curves = new Curves(byId("curves"));
    this.tabs = byId("panel-buttons");
    this.tabs.addEventListener("keydown", (event) => this.step(event));
    this.hide();
  }

  hide() {
    this.run = "";
    this.tabs.replaceChildren();
    this.viewer.hide();
    this.states.hide();
    this.curves.hide();
  }

  // Adds what is new of a run; the tab that is open stays open.
  show(state) {
    if (this.run !== state.id) {
      this.hide();
      this.run = state.id;
      if (state.answers.length > 1 && !CYCLES.includes(state.settings.load)) this.add("curves", () => this.curves.show(state));
    }
    const known = [...this.tabs.children].map((tab) => tab.dataset.panel);
    for (const output of state.outputs) {
      if (output.role === "picture" && !known.includes(output.panel)) this.add(output.panel, () => this.look(state, output));
    }
    this.tabs.hidden = this.tabs.children.length < 2;
  }

  add(panel, act) {
    const tab = element("button", panel.replaceAll("-", " "), {
      type: "button", role: "tab", id: `tab-${panel}`, "aria-controls": "panel", "aria-selected": "false", tabindex: "-1", "data-panel": panel,
    });
    tab.addEventListener("click", () => this.open(tab, act));
    this.tabs.append(tab);
    if (this.tabs.children.length === 1) tab.click();
  }

  open(tab, act) {
    for (const other of this.tabs.children) {
      other.setAttribute("aria-selected", String(other === tab));
      other.tabIndex = other === tab ? 0 : -1;
    }
    byId("panel").setAttribute("aria-labelledby", tab.id);
    this.curves.hide();
    this.states.hide();
    act();
  }

  look(state, output) {
    if (output.states) this.states.show(state.id, output);
    else this.viewer.show(`runs/${state.id}/${output.file}`, `The ${output.panel.replaceAll("-", " ")} of this contact`);
  }

  step(event) {
    const tabs = [...this.tabs.children];
    const here = tabs.indexOf(document.activeElement);
    const to = { ArrowLeft: here - 1, ArrowRight: here + 1, Home: 0, End: tabs.length - 1 }[event.key];
    if (to === undefined || here < 0 || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    const next = tabs[(to + tabs.length) % tabs.length];
    next.focus();
    next.click();
  }
}
