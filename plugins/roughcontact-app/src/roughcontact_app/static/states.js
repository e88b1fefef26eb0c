// The states of a path: a slider, and a picture of that at which it stands, which the server draws when it is asked.

import { post } from "./api.js";
import { byId, say } from "./page.js";

export class States {
  constructor(viewer) {
    this.viewer = viewer;
    this.slider = byId("state");
    this.slider.addEventListener("input", () => this.choose());
  }

  // A panel of the states of a run; the slider stays where it stands while another panel of that run is looked at.
  show(run, { panel, states }) {
    if (this.run !== run) this.slider.max = this.slider.value = states.length;
    Object.assign(this, { run, panel, names: states, drawn: "" });
    byId("path-states").hidden = false;
    this.choose();
  }

  hide() {
    this.panel = "";
    byId("path-states").hidden = true;
  }

  choose() {
    const name = this.names[this.slider.value - 1];
    byId("state-name").textContent = name;
    this.slider.setAttribute("aria-valuetext", name);
    if (!this.drawing) this.draw();
  }

  // One picture at a time: while it is drawn the slider may go on, and then only where it stands now is drawn.
  async draw() {
    const { run, panel } = this;
    const state = Number(this.slider.value);
    const wanted = `${run} ${panel} ${state}`;
    if (!panel || wanted === this.drawn) return;
    const isNew = !this.drawn;
    this.drawing = true;
    // Until then the picture is of another state.
    this.viewer.place.setAttribute("aria-busy", "true");
    this.drawn = wanted;
    let problem = "";
    try {
      const { picture } = await post("api/state", { run, panel, state });
      if (run === this.run && panel === this.panel) {
        this.viewer.show(`pictures/${picture}`, `The ${panel.replaceAll("-", " ")} of ${this.names[state - 1]}`, !isNew);
      }
    } catch (error) {
      problem = error.message;
    }
    this.drawing = false;
    this.viewer.place.removeAttribute("aria-busy");
    say("state-problem", problem);
    this.draw();
  }
}
