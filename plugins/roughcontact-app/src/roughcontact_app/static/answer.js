// The answer of a run: its numbers with their uncertainty, its certificate, its warnings and its table.

import { byId, element, say, showList } from "./page.js";
import { isPath } from "./words.js";

// Loads without a value of their own.
export const CYCLES = ["cycle", "fretting"];
// The quantity that a kind of load gives.
export const GIVEN = { pressure: "mean pressure", force: "force", approach: "approach", film: "separation over Sq" };
// What is shown first, if it is answered; of cycles all but the table's details.
const FIRST = ["contact area", "maximum pressure", "approach", "stiffness"];
const FIRST_OF_FILM = ["phi xx", "phi yy", "phi s xx", "asperity pressure"];
const MOST_TILES = 4;
// Parts of a value: an uncertainty above these is doubtful, and bad.
const DOUBTFUL = 0.1;
const BAD = 0.5;

export const quantity = (answer, name) => answer.quantities.find((one) => one.name === name);

export function renderAnswer(state) {
  const last = shownAnswer(state);
  const many = state.answers.length > 1;
  byId("answer").hidden = false;
  byId("headline").textContent = headlineOf(state);
  byId("numbers").replaceChildren(...tilesOf(last, state.settings).map((one) => tile(one, last)));
  const failed = state.answers.filter((answer) => !answer.certified);
  const statuses = [...new Set((failed.length ? failed : state.answers).map((answer) => answer.status))];
  byId("verdict").replaceChildren(
    element("strong", failed.length ? "✗ Not certified" : "✓ Certified"),
    ` ${statuses.join("; ")}. ± is one standard deviation${isCompared(last) ? "; Hertz's closed form is that of the same ball" : ""}.`,
  );
  byId("verdict").className = failed.length ? "alert" : "";
  say("places", last.note || last.places && `Other places of the surface${many ? `, at ${last.load}` : ""}: ${last.places}`);
  showList(byId("warnings"), state.warnings);
  byId("answer-table").replaceChildren(...(many ? curveRows(state) : singleRows(last)));
  byId("look").classList.toggle("wide", many);
}

// The last load; of a film the middle separation, since the walls are smooth to it where they are far apart.
const shownAnswer = ({ settings, answers }) => answers.at(settings.load === "film" ? Math.floor(answers.length / 2) : -1);

function headlineOf({ settings, answers }) {
  if (CYCLES.includes(settings.load)) return settings.load === "cycle" ? "A cycle of approaches" : "A fretting cycle";
  if (settings.load === "film") return `${answers.length} separations solved; at ${shownAnswer({ settings, answers }).load}:`;
  if (isPath(settings)) return `${answers.length} states of the path; at the end:`;
  return answers.length > 1 ? `${answers.length} loads solved; at ${answers.at(-1).load}:` : `At ${answers[0].load}:`;
}

function tilesOf(answer, { load }) {
  const wanted = (load === "film" ? FIRST_OF_FILM : FIRST).map((name) => quantity(answer, name)).filter((one) => one && one.name !== GIVEN[load]);
  return (CYCLES.includes(load) ? answer.quantities : wanted).slice(0, MOST_TILES);
}

const isCompared = (answer) => Object.keys(answer.closed_form || {}).length > 0;

// A quantity: its value, its uncertainty with a bar, and what a closed form says.
function tile({ name, text, value, uncertainty, sampling }, answer) {
  const made = element("div", "", { class: "tile" });
  const [number, own] = separate(text);
  made.append(element("dt", name), element("dd", number, { class: "number" }));
  const part = value ? Math.abs(uncertainty / value) : 0;
  if (own) {
    made.append(element("dd", `± ${own}${value ? ` (${percent(part)})` : ""}`, { class: "help" }), barOf(part));
  }
  if (sampling) {
    const [shown, unit] = number.split(" ");
    made.append(element("dd", placesOf(sampling * scaleOf(shown, value), unit), { class: "help" }));
  }
  const known = answer.closed_form?.[name];
  const fraction = name === "contact area" && quantity(answer, "contact area fraction");
  // Of a ball the domain is chosen at will.
  if (fraction && !known) made.append(element("dd", `${percent(fraction.value)} of nominal`, { class: "help" }));
  if (known) made.append(element("dd", `Hertz ${write(known, number, value)}${compare(value, known)}`, { class: "help" }));
  return made;
}

// The value and the uncertainty of a text such as (2.5 ± 0.1) mm, each with the unit.
function separate(text) {
  const [, number, own, unit] = text.match(/^\(?(\S+) ± ([^\s)]+)\)?(.*)$/) || [];
  return own === undefined ? [text, ""] : [`${number}${unit}`, `${own}${unit}`];
}

const percent = (part) => `${100 * part < 0.001 && part ? "below 0.001" : Number((100 * part).toPrecision(part < 0.1 ? 2 : 3))} %`;

// How much other places differ, in a unit.
export const placesOf = (size, unit) => `other places ± ${Number(size.toPrecision(2))} ${unit || ""}`.trimEnd();

// What a value in SI units is multiplied with in a text.
const scaleOf = (shown, value) => (Number(shown) && value ? 10 ** Math.round(Math.log10(Math.abs(shown / value))) : 1);

// A number in SI units in the unit and with the decimals of a text of another one.
function write(known, text, value) {
  const [, number, decimals = "", unit] = text.match(/^(-?\d+(?:\.(\d+))?)( .*)$/) || [];
  if (!unit) return known.toPrecision(6);
  return `${(known * scaleOf(number, value)).toFixed(decimals.length)}${unit}`;
}

function compare(value, known) {
  const part = value / known - 1;
  return Math.abs(part) < 1e-5 ? ", the same to 0.001 %" : `, ${percent(Math.abs(part))} ${part > 0 ? "less" : "more"}`;
}

// As wide as the uncertainty on a line from nothing to twice the value.
function barOf(part) {
  const line = element("dd", "", { class: "line", "aria-hidden": "true" });
  const band = element("span", "", { class: part >= BAD ? "bad" : part >= DOUBTFUL ? "doubtful" : "" });
  const width = 100 * Math.min(part, 1);
  band.style.left = `${50 - width / 2}%`;
  band.style.width = `${width}%`;
  line.append(band);
  return line;
}

function singleRows(answer) {
  const rows = answer.quantities.map((one) => {
    const row = element("tr");
    row.append(element("th", one.name, { scope: "row" }), element("td", one.text, { "data-quantity": one.name }));
    row.lastChild.dataset.value = one.value;
    return row;
  });
  return [element("caption", "The answer", { class: "unseen" }), body(rows)];
}

function body(rows) {
  const made = element("tbody");
  made.append(...rows);
  return made;
}

// The number of a text, and its unit, which is that of its whole column.
export function split({ text, unit }) {
  const end = unit ? text.lastIndexOf(" ") : text.length;
  return [text.slice(0, end), text.slice(end + 1)];
}

function curveRows(state) {
  const names = state.answers[0].quantities.map((one) => one.name);
  const isFilm = state.settings.load === "film";
  const leading = ["mean pressure", "force"].filter((name) => names.includes(name));
  const order = [...leading, ...names.filter((name) => !leading.includes(name))];
  const head = element("tr");
  const titles = order.map((name) => [name, split(quantity(state.answers[0], name))[1]].filter(Boolean).join(", "));
  head.append(...[...titles, ...(isFilm ? [] : ["fields"])].map((title) => element("th", title, { scope: "col" })));
  const rows = state.answers.map((answer, index) => {
    const row = element("tr");
    for (const name of order) {
      const one = quantity(answer, name);
      const [number] = split(one);
      // A load stands as it was given.
      const isShort = one.uncertainty || name === GIVEN[state.settings.load] || !Number.isFinite(Number(number));
      row.append(element("td", isShort ? number : String(Number(Number(number).toPrecision(3))), { "data-quantity": name }));
      row.lastChild.dataset.value = one.value;
    }
    if (!isFilm) row.append(element("td", "", { "data-files": index }));
    return row;
  });
  // Each column as a file of its own.
  if (isFilm) {
    const files = element("tr");
    files.append(...order.map((name) => element("td", "", { "data-text": name })));
    rows.push(files);
  }
  const top = element("thead");
  top.append(head);
  return [element("caption", `The answers, a row for each ${isFilm ? "separation" : isPath(state.settings) ? "state" : "load"}`, { class: "unseen" }), top, body(rows)];
}
