// The answers of several loads, or states, as a curve whose values are read by pointer or arrow keys.

import { GIVEN, placesOf, quantity, split } from "./answer.js";
import { byId, element, say } from "./page.js";
import { fill } from "./fields.js";
import { darkness } from "./settings.js";
import { isPath } from "./words.js";

// Over a greater range than this the axes are logarithmic.
const WIDE = 30;
const HEIGHT = 300;
// What falls by powers of ten over the separation of a film.
const FALLING = ["asperity pressure", "area"];

const color = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

export class Curves {
  constructor(place) {
    this.place = place;
    this.select = element("select", "", { id: "curve-quantity" });
    this.select.addEventListener("change", () => this.draw());
    const field = element("div", "", { class: "field" });
    field.append(element("label", "Quantity", { for: "curve-quantity" }), this.select);
    this.frame = element("div", "", { id: "curve", tabindex: "0", role: "group", "aria-label": "Curve. Left and right arrows read its points." });
    this.frame.addEventListener("keydown", (event) => this.step(event));
    place.append(field, this.frame, element("p", "", { id: "curve-point", role: "status", class: "shown" }));
    new ResizeObserver(() => this.fit()).observe(place);
    // Its colours are those of the page.
    darkness.addEventListener("change", () => { if (!place.hidden) this.draw(); });
  }

  hide() {
    this.place.hidden = true;
  }

  show({ answers, settings }) {
    byId("picture").hidden = true;
    this.place.hidden = false;
    if (this.answers !== answers) {
      const given = isPath(settings) ? "" : GIVEN[settings.load];
      const counts = ({ name }) => name !== given && new Set(answers.map((answer) => quantity(answer, name).value)).size > 1;
      const names = answers[0].quantities.filter(counts).map((one) => one.name);
      fill(this.select, Object.fromEntries(names.map((name) => [name, name])));
      for (const first of ["contact area", "phi xx"]) if (names.includes(first)) this.select.value = first;
      Object.assign(this, { answers, given });
    }
    this.draw();
  }

  // The numbers of a quantity in the unit of its texts, by the order of what is given.
  column(name) {
    const all = this.order.map((answer) => quantity(answer, name));
    const unit = split(all.find((one) => one.value) || all[0])[1];
    const largest = all.reduce((one, other) => (Math.abs(other.value) > Math.abs(one.value) ? other : one));
    const shown = Number(split(largest)[0].replace("(", "").split(" ")[0]);
    const scale = shown && largest.value ? 10 ** Math.round(Math.log10(Math.abs(shown / largest.value))) : 1;
    return { unit, title: unit ? `${name}, ${unit}` : name, values: all.map((one) => one.value * scale), errors: all.map((one) => one.uncertainty * scale), places: all.some((one) => one.sampling) ? all.map((one) => one.sampling * scale) : null, texts: all.map((one) => one.text) };
  }

  draw() {
    const { answers, given } = this;
    this.order = given ? [...answers].sort((one, other) => quantity(one, given).value - quantity(other, given).value) : answers;
    const across = given ? this.column(given) : { title: "state", values: answers.map((_, index) => index + 1), texts: answers.map((answer) => answer.load) };
    const up = this.column(this.select.value);
    Object.assign(this, { across, up, at: -1 });
    this.chart?.destroy();
    // Zeros of what falls by powers of ten are not drawn, and no end of a band is below zero.
    up.falls = given === GIVEN.film && FALLING.includes(this.select.value) && up.values.some((value) => value > 0);
    const shown = up.values.map((value) => (up.falls && !(value > 0) ? null : value));
    const end = (sign, sizes) => shown.map((value, index) => {
      const at = value === null ? null : value + sign * sizes[index];
      return up.falls && at !== null ? Math.max(at, 0.05 * value) : at;
    });
    const ends = [up.places, up.errors].filter(Boolean).flatMap((sizes) => [end(1, sizes), end(-1, sizes)]);
    this.chart = new uPlot(this.options(), [across.values, ...ends, shown], this.frame);
    say("curve-point", "");
  }

  options() {
    const axis = (label) => ({
      label, stroke: color("--ink"), grid: { stroke: color("--faint"), width: 1 }, ticks: { stroke: color("--faint"), width: 1 },
      font: "13px system-ui", labelFont: "13px system-ui", size: label === this.up.title ? 70 : 44, values: (_, marks) => marks.map((mark) => (mark === null ? "" : String(Number(mark.toPrecision(6))))),
    });
    const [least, most] = [Math.min, Math.max].map((end) => end(...this.across.values));
    const isWide = least > 0 && most > WIDE * least && this.up.values.every((value, index) => value > this.up.errors[index]);
    const scale = { time: false, distr: isWide ? 3 : 1 };
    const [accent, faint] = [color("--accent"), color("--faint")];
    const end = (stroke) => ({ stroke, width: 1, points: { show: false } });
    // Around the value that of other places, and within it that of the grid.
    const fills = this.up.places ? [faint, color("--line")] : [faint];
    return {
      width: this.place.clientWidth, height: HEIGHT, legend: { show: false }, scales: { x: scale, y: { ...scale, distr: isWide || this.up.falls ? 3 : 1 } },
      cursor: { drag: { setScale: false, x: false, y: false }, points: { size: 11, fill: accent } },
      axes: [axis(this.across.title), axis(this.up.title)],
      bands: fills.map((fill, index) => ({ series: [2 * index + 1, 2 * index + 2], fill })),
      series: [{}, ...fills.flatMap((fill) => [end(fill), end(fill)]), { stroke: accent, width: 2, points: { show: true, size: 8, fill: accent } }],
      hooks: { setCursor: [({ cursor: { idx } }) => { if (idx !== null && idx !== undefined) this.tell(idx); }] },
    };
  }

  tell(index) {
    this.at = index;
    const places = this.up.places?.[index];
    const more = places ? `; ${placesOf(places, this.up.unit)}` : "";
    say("curve-point", `${this.given || "state"} ${this.given ? this.across.texts[index] : `${this.across.values[index]} (${this.across.texts[index]})`}: ${this.select.value} ${this.up.texts[index]}${more}`);
  }

  step(event) {
    const last = this.across.values.length - 1;
    const to = { ArrowLeft: Math.max(this.at - 1, 0), ArrowRight: Math.min(this.at + 1, last), Home: 0, End: last }[event.key];
    if (to === undefined || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    this.chart.setCursor({ left: this.chart.valToPos(this.across.values[to], "x"), top: this.chart.valToPos(this.up.values[to], "y") });
    this.tell(to);
  }

  fit() {
    if (this.chart && this.place.clientWidth) this.chart.setSize({ width: this.place.clientWidth, height: HEIGHT });
  }
}
