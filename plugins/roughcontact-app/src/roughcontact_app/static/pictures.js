// The pictures of a run in tabs: each is fetched, and drawn by the server, when its tab is opened.

import { CYCLES } from "./answer.js";
import { Curves } from "./curves.js";
import { byId, element } from "./page.js";
import { States } from "./states.js";
import { Viewer } from "./viewer.js";

// What a panel looks like, by its name: a drawing of each would take seconds that nobody waits for.
const LOOKS = [
  [/histogram|sizes|forces/, "bars"],
  [/load|^(curves|course|cycle|loop|profile|area|asperity-pressure|phi-.*)$/, "line"],
  [/zone|stress/, "depth"],
];
const SIGNS = {
  field: ["M1.5 1.5h13v13h-13z", "M4 6.5c1.5-2 4-1 4 .5s3.5.5 4 2-2 3.5-4 2.5S3 9 4 6.5z"],
  line: ["M1.5 1.5v13h13", "M4 12c4 0 4-8 9-9"],
  bars: ["M1.5 1.5v13h13", "M5 14.5V9M8.5 14.5V4M12 14.5v-3"],
  depth: ["M.5 3.5h15", "M4 3.5a4 8 0 0 0 8 0M6 3.5a2 4 0 0 0 4 0"],
};

function signOf(panel) {
  const [, look = "field"] = LOOKS.find(([names]) => names.test(panel)) || [];
  const make = (name, attributes) => {
    const made = document.createElementNS("http://www.w3.org/2000/svg", name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    return made;
  };
  const sign = make("svg", { viewBox: "0 0 16 16", "aria-hidden": "true", class: "sign", "data-look": look });
  sign.append(...SIGNS[look].map((d) => make("path", { d })));
  return sign;
}

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
    tab.prepend(signOf(panel));
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
