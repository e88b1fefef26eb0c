// The fields of the form that follow from what is installed: units, layers, tick boxes, materials, typical values.

import { element } from "./page.js";

const form = document.getElementById("settings");
// Settings of typical materials by name, and what the page asks for of materials of plug-ins.
export let typical = {};
export let materials = [];

// Makes them all, before there are values.
export function makeFields(start) {
  ({ typical, materials } = start);
  copyFieldsOfMap();
  for (const one of materials) addMaterial(one);
  copyFieldsOfBody();
  for (const place of form.querySelectorAll("[data-layers]")) addLayers(place);
  for (const one of start.responses) addTickBox("responses", one);
  for (const one of start.laws) addTickBox("laws", one);
  fill(form.elements.example, Object.fromEntries(start.examples.map((name) => [name, name.replaceAll("_", " ")])));
  for (const select of form.querySelectorAll("[data-units]")) fill(select, UNITS[select.dataset.units]);
  for (const select of form.querySelectorAll("[data-preset]")) select.addEventListener("change", () => choosePreset(select));
}

export const UNITS = {
  length: { m: "m", mm: "mm", um: "µm", nm: "nm" },
  modulus: { Pa: "Pa", MPa: "MPa", GPa: "GPa" },
  pressure: { Pa: "Pa", kPa: "kPa", MPa: "MPa", GPa: "GPa" },
  force: { N: "N", mN: "mN", uN: "µN", nN: "nN", kN: "kN" },
  approach: { mm: "mm", um: "µm", nm: "nm" },
  work: { "J/m2": "J/m²", "mJ/m2": "mJ/m²" },
  viscosity: { "Pa s": "Pa s", "mPa s": "mPa s" },
  time: { s: "s", ms: "ms", us: "µs" },
};
// Cycles have fields of their own; those of a load keep what they hold at first.
UNITS.cycle = UNITS.fretting = UNITS.film = UNITS.pressure;

export function fill(select, options) {
  select.replaceChildren(...Object.entries(options).map(([value, text]) => new Option(text, value)));
}

export const textOf = (control) => (control.type === "checkbox" ? (control.checked ? "yes" : "no") : control.value);

export function setText(control, text) {
  if (control.type === "checkbox") control.checked = text === "yes";
  else control.value = text;
}

// The counterbody and its map have the fields of the body, whose names begin with its prefix.
export const OTHER = "counterbody_";

function copyField(field) {
  const copy = field.cloneNode(true);
  for (const part of [copy, ...copy.querySelectorAll("*")]) {
    for (const name of ["id", "name", "for", "aria-describedby", "data-when"]) {
      if (part.hasAttribute(name)) part.setAttribute(name, OTHER + part.getAttribute(name));
    }
    if (part.dataset.preset !== undefined) part.dataset.preset = OTHER;
    if (part.hasAttribute("aria-label")) part.setAttribute("aria-label", `${part.getAttribute("aria-label")} of the counterbody`);
  }
  return copy;
}

function copyFieldsOfBody() {
  for (const field of form.querySelectorAll("#material-fields > :not(legend, [data-layers])")) {
    document.getElementById(`${OTHER}material-fields`).append(copyField(field));
  }
}

function copyFieldsOfMap() {
  for (const field of form.querySelectorAll("[data-map]")) {
    const copy = copyField(field);
    copy.dataset.when = `${OTHER}surface=file`;
    copy.dataset.map = OTHER;
    document.getElementById(`${OTHER}fields`).append(copy);
  }
}

// The number of layers of a body, and the fields of each, from the surface downwards.
const MOST_LAYERS = 3;

function addLayers(place) {
  const { layers: prefix, of } = place.dataset;
  const counts = Array.from({ length: MOST_LAYERS + 1 }, (_, count) => count);
  const select = element("select", "", { id: `${prefix}layers`, name: `${prefix}layers` });
  fill(select, Object.fromEntries(counts.map((count) => [count, count === 0 ? "none" : `${count} layer${count > 1 ? "s" : ""}`])));
  place.append(labelled(`${prefix}layers`, `Coating of ${of}`, select));
  for (const number of counts.slice(1)) {
    const set = element("fieldset", "", { "data-when": `${prefix}layers=${counts.slice(number).join(" ")}` });
    set.append(element("legend", `Layer ${number} of ${of}${number === 1 ? ", at the surface" : ""}`));
    for (const [name, label, kind] of [
      ["young", "Young's modulus", "modulus"],
      ["poisson", "Poisson's ratio", ""],
      ["thickness", "Thickness", "length"],
      ["yield_stress", "Yield stress, for its first yield (empty: that of the body)", "modulus"],
    ]) {
      const setting = `${prefix}layer${number}_${name}`;
      const row = element("span", "", { class: "row" });
      row.append(element("input", "", { id: setting, name: setting, inputmode: "decimal" }));
      if (kind) row.append(element("select", "", { name: `${setting}_unit`, "aria-label": `Unit of ${label} of layer ${number} of ${of}`, "data-units": kind }));
      set.append(labelled(setting, label, row));
    }
    place.append(set);
  }
}

// A tick box for what the contact does, or for a law, and below it its fields.
function addTickBox(place, { setting, label, summary, fields, axis }) {
  const line = element("label", "", { class: "tick" });
  const words = element("span");
  words.append(element("b", label), element("span", sentence(summary), { class: "help" }));
  line.append(element("input", "", { type: "checkbox", name: setting, value: "yes" }), words);
  const below = element("div", "", { "data-when": `${setting}=yes`, class: "ticked" });
  for (const one of fields) below.append(numberField(one));
  if (axis) {
    const select = element("select", "", { id: axis, name: axis });
    fill(select, { x: "x", y: "y" });
    below.append(labelled(axis, "Axis", select));
  }
  document.getElementById(place).append(line, ...(below.children.length ? [below] : []));
}

// The field of a number, or of several.
function numberField({ setting, label, kind }, inputmode = "decimal") {
  const row = element("span", "", { class: "row" });
  row.append(element("input", "", { id: setting, name: setting, inputmode }));
  if (kind) row.append(element("select", "", { name: `${setting}_unit`, "aria-label": `Unit of the ${label}`, "data-units": kind }));
  return labelled(setting, label, row);
}

// A material of a plug-in, whose fields stand below the choice of the material, beside those that many have.
function addMaterial({ name, label, summary, shared, fields }) {
  form.elements.material.append(new Option(label, name));
  for (const field of shared) form.querySelector(`[data-shared=${field}]`).dataset.when += ` ${name}`;
  const place = element("div", "", { "data-when": `material=${name}` });
  place.append(summarized(summary), ...fields.flatMap(partFields));
  document.getElementById("other-materials").append(place);
}

const sentence = (text) => `${text[0].toUpperCase()}${text.slice(1)}${text.endsWith(".") ? "" : "."}`;

const summarized = (text) => element("p", sentence(text), { class: "help summary" });

// The field of a number or a list, or the choice of a part with the fields of each.
function partFields({ field, is_needed: isNeeded, is_list: isList, parts }) {
  if (!parts.length) return [numberField(isList ? { ...field, label: `${field.label}: several, with blanks between them` } : field, isList ? "text" : "decimal")];
  const { setting, label } = field;
  const select = element("select", "", { id: setting, name: setting });
  fill(select, { ...(isNeeded ? {} : { none: "none" }), ...Object.fromEntries(parts.map((part) => [part.name, part.label])) });
  const below = parts.map((part) => {
    const made = element("div", "", { "data-when": `${setting}=${part.name}`, class: "ticked" });
    made.append(summarized(part.summary), ...part.fields.flatMap(partFields));
    return made;
  });
  return [labelled(setting, label, select), ...below];
}

function labelled(id, text, control) {
  const field = element("div", "", { class: "field" });
  field.append(element("label", text, { for: id }), control);
  return field;
}


function choosePreset({ value, dataset: { preset: prefix } }) {
  for (const [name, text] of Object.entries(typical[value] || {})) setText(form.elements[prefix + name], text);
}

// The name of the typical material whose values a body has, from settings; empty if there is none.
export function nameMaterial(values, prefix) {
  // The unit of an empty field does not count.
  const isEmpty = (others, name) => name.endsWith("_unit") && !others[name.replace(/_unit$/, "")];
  const holds = (others) => Object.keys(others).every((name) => isEmpty(others, name) || values[prefix + name].trim() === others[name]);
  return Object.keys(typical).find((name) => holds(typical[name])) || "";
}

// Typical values of the material that is chosen; a name stands only beside its own numbers.
export function showPresets(values) {
  for (const select of form.querySelectorAll("[data-preset]")) {
    const { preset: prefix } = select.dataset;
    const fitting = Object.keys(typical).filter((name) => typical[name].material === values[`${prefix}material`]);
    const names = ["", ...fitting];
    if (names.join() !== [...select.options].map((option) => option.value).join()) {
      fill(select, Object.fromEntries(names.map((name) => [name, name || "choose"])));
    }
    select.value = nameMaterial(values, prefix);
    select.closest(".field").hidden = !fitting.length;
  }
}

