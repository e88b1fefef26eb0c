// The form, its dependent fields, and the link that holds it.

import { element } from "./page.js";

export const form = document.getElementById("settings");
const UNITS = {
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
UNITS.cycle = UNITS.fretting = UNITS.pressure;
// At first for each kind of load: a value and its unit.
const FIRST_LOADS = { pressure: ["100", "MPa"], force: ["1", "N"], approach: ["0.1", "um"], cycle: ["100", "MPa"], fretting: ["100", "MPa"] };
const FORMS = { plane: "its plane", quadratic: "its form of second degree", sphere: "its sphere" };
let defaults = {};
// Settings of typical materials by name, and what the page asks for of materials of plug-ins.
let typical = {};
let materials = [];

export const darkness = matchMedia("(prefers-color-scheme: dark)");

function fill(select, options) {
  select.replaceChildren(...Object.entries(options).map(([value, text]) => new Option(text, value)));
}

// The page's own first values are those of the server, so that the link can omit them.
export function prepare(start) {
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
  defaults = start.defaults;
  write({});
}

function choosePreset({ value, dataset: { preset: prefix } }) {
  for (const [name, text] of Object.entries(typical[value] || {})) setText(form.elements[prefix + name], text);
}

// Typical values of the material that is chosen; a name stands only beside its own numbers.
function showPresets() {
  for (const select of form.querySelectorAll("[data-preset]")) {
    const text = (name) => textOf(form.elements[select.dataset.preset + name]).trim();
    const fitting = Object.keys(typical).filter((name) => typical[name].material === text("material"));
    const names = ["", ...fitting];
    if (names.join() !== [...select.options].map((option) => option.value).join()) {
      fill(select, Object.fromEntries(names.map((name) => [name, name || "choose"])));
    }
    // The unit of an empty field does not count.
    const isEmpty = (values, name) => name.endsWith("_unit") && !values[name.replace(/_unit$/, "")];
    const holds = (values) => Object.keys(values).every((name) => isEmpty(values, name) || text(name) === values[name]);
    select.value = fitting.find((name) => holds(typical[name])) || "";
    select.closest(".field").hidden = !fitting.length;
  }
}

// The counterbody and its map have the fields of the body, whose names begin with its prefix.
const OTHER = "counterbody_";

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
  words.append(element("b", label), element("span", summary, { class: "help" }));
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

const summarized = (text) => element("p", `${text[0].toUpperCase()}${text.slice(1)}.`, { class: "help summary" });

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

const textOf = (control) => (control.type === "checkbox" ? (control.checked ? "yes" : "no") : control.value);

function setText(control, text) {
  if (control.type === "checkbox") control.checked = text === "yes";
  else control.value = text;
}

const hidden = { file: "", file_name: "", [`${OTHER}file`]: "", [`${OTHER}file_name`]: "" };

// Whether a map in a file is solved; what is not shown is not.
export const isFile = (kind) => form.elements[kind].value === "file" && !form.elements[kind].closest("[hidden]");

export function read() {
  const found = { ...hidden, scheme: darkness.matches ? "dark" : "light" };
  for (const name of Object.keys(defaults)) {
    const control = form.elements[name];
    if (control) found[name] = textOf(control);
  }
  return found;
}

export function write(values) {
  const all = { ...defaults, ...values };
  fill(form.elements.load_unit, UNITS[all.load] || UNITS.pressure);
  for (const [name, value] of Object.entries(all)) {
    if (name in hidden) hidden[name] = value;
    else if (form.elements[name]) setText(form.elements[name], value);
  }
}

export function setFile(prefix, digest, name) {
  Object.assign(hidden, { [`${prefix}file`]: digest, [`${prefix}file_name`]: name });
}

export function loadKindChanged() {
  const kind = form.elements.load.value;
  fill(form.elements.load_unit, UNITS[kind]);
  [form.elements.loads.value, form.elements.load_unit.value] = FIRST_LOADS[kind];
}

export function reset(name) {
  form.elements[name].value = defaults[name];
}

// A surface that repeats is solved as such, others are not; the user may still change it. Returns what to say of it.
export function surfaceKindChanged() {
  const { surface, boundary } = form.elements;
  const before = boundary.value;
  boundary.value = ["self-affine", "wavy"].includes(surface.value) ? "periodic" : "free";
  return before === boundary.value ? "" : `It was ${before}; for this surface it is now ${boundary.value}.`;
}

// Says under a field what is wrong with it; without an error nothing is wrong.
export function markWrong({ setting = "", message = "" } = {}) {
  form.querySelector(".wrong")?.remove();
  form.querySelector("[aria-invalid]")?.removeAttribute("aria-invalid");
  const control = form.elements[setting];
  if (!control || control.closest("[hidden]")) return;
  control.setAttribute("aria-invalid", "true");
  control.setAttribute("aria-errormessage", "wrong");
  (control.closest(".field") || control.parentElement).append(element("p", message, { class: "wrong", id: "wrong" }));
}

const needsOf = (facts) => facts && {
  size: facts.size === null, metric: !facts.metric, rows: facts.needs_rows, non_measured: facts.non_measured > 0,
};

// The facts that each file states, by the prefix of its map.
export function showFields(facts) {
  for (const part of form.querySelectorAll("[data-when]")) {
    const [name, values] = part.dataset.when.split("=");
    // A registered name may have blanks.
    const wanted = ` ${values} `.includes(` ${textOf(form.elements[name])} `);
    part.hidden = !wanted || (part.dataset.need !== undefined && !needsOf(facts[part.dataset.map])?.[part.dataset.need]);
  }
  showPresets();
  for (const [prefix, known] of Object.entries(facts)) {
    if (needsOf(known)?.size) document.getElementById(`${prefix}size-help`).textContent = whichIsX(prefix, known);
  }
}

function whichIsX(prefix, { shape: [first, second], needs_rows: open }) {
  const isText = /\.(csv|tsv|txt|dat|asc)$/i.test(hidden[`${prefix}file_name`]);
  const rows = isText ? `${first} lines of the file` : `${first} points, along the first index`;
  const columns = isText ? `${second} values in each` : `${second} points, along the second`;
  return open && form.elements[`${prefix}rows`].value === "y" ? `x: ${columns}; y: ${rows}.` : `x: ${rows}; y: ${columns}.`;
}

// Only what differs from the first values, so that links stay short.
export function toFragment(run) {
  const changed = Object.entries(read()).filter(([name, value]) => name !== "scheme" && value !== defaults[name]);
  const query = new URLSearchParams(changed);
  if (run) query.set("run", run);
  return query.toString();
}

// Settings and run of a link, or the problem with it, in a sentence.
export function fromFragment(text) {
  const { run = "", ...values } = Object.fromEntries(new URLSearchParams(text.trim().replace(/^[^#]*#/, "")));
  const unknown = Object.keys(values).find((name) => !(name in defaults));
  if (unknown !== undefined) return { problem: `This is no link to settings of this page: it has no setting '${unknown}'.` };
  const wrong = Object.keys(values).find((name) => !isChoice(name, values));
  if (wrong) return { problem: `The link is not used: its '${wrong}' is '${values[wrong]}', which the page does not offer.` };
  return { run, values, problem: "" };
}

function isChoice(name, values) {
  const control = form.elements[name];
  if (name === "load_unit") return values[name] in UNITS[values.load || defaults.load];
  if (control?.type === "checkbox") return ["yes", "no"].includes(values[name]);
  return control?.tagName !== "SELECT" || [...control.options].some((option) => option.value === values[name]);
}

// Whether the form asks for something else than a run had; what is hidden does not count.
export function differ(others) {
  const own = read();
  const kinds = { file: "surface", [`${OTHER}file`]: `${OTHER}surface` };
  const counts = (name) => (name in kinds ? isFile(kinds[name]) : form.elements[name] && !form.elements[name].closest("[hidden]"));
  return Object.keys(defaults).some((name) => counts(name) && own[name].trim() !== others[name]);
}

export const isPath = ({ load, path }) => path === "yes" && ["pressure", "force", "approach"].includes(load);

function describePath(values, of) {
  // A list that ends with a unit needs none.
  const listed = (name) => (/[a-z]$/i.test(values[name]) ? values[name] : of(name));
  const passing = ["time", "sliding"].filter((name) => values[name]).map((name) => `${name} ${listed(name)}`);
  return ["a path", ...passing, ...ticked(values, "law_")].join(", ");
}

// What is ticked, in words, of the boxes whose names begin alike.
const ticked = (values, prefix) => [...form.querySelectorAll(`[type=checkbox][name^=${prefix}]`)]
  .filter(({ name }) => values[name] === "yes").map(({ name }) => name.replace(prefix, "").replaceAll("_", " "));

export const subjectOf = ({ surface, file_name: name, example }) => ({ file: name || "map", example: example.replaceAll("_", " ") }[surface] || surface);

function describeOther(values, of) {
  const parts = [`on ${values.counterbody_file_name || "map"}`];
  if (values.counterbody_form !== "none") parts.push(`less ${FORMS[values.counterbody_form]}`);
  if (Number(values.offset_x) || Number(values.offset_y)) parts.push(`shifted by ${values.offset_x}, ${of("offset_y", "offset_unit")}`);
  if (Number(values.rotation)) parts.push(`rotated by ${values.rotation}°`);
  if (values.mirrored === "yes") parts.push("mirrored");
  return parts.join(" ");
}

// What is given of the fields of a part, in words.
function describeFields(fields, values, of, prefix) {
  return fields.flatMap(({ field, parts }) => {
    const text = values[`${prefix}${field.setting}`];
    const part = parts.find((one) => one.name === text);
    if (parts.length) return part ? [`${part.label.toLowerCase()} (${describeFields(part.fields, values, of, prefix).join("; ")})`] : [];
    return text ? [`${field.name.replaceAll("_", " ")} ${field.kind ? of(`${prefix}${field.setting}`) : text}`] : [];
  });
}

// What a run has solved, in a line.
export function describe(values) {
  const of = (name, unit = `${name}_unit`) => `${values[name]} ${values[unit].replace(/^u/, "µ")}`;
  const material = (prefix) => {
    const hard = values[`${prefix}hardness`] ? `hardness ${of(`${prefix}hardness`)}` : "elastic";
    if (values[`${prefix}material`] === "viscoelastic") return `moduli ${of(`${prefix}moduli`)} relaxing in ${of(`${prefix}relaxation`)}`;
    const other = materials.find(({ name }) => name === values[`${prefix}material`]);
    if (other) {
      const shared = { young: () => `E ${of(`${prefix}young`)}`, poisson: () => `ν ${values[`${prefix}poisson`]}` };
      return [other.label, ...other.shared.map((name) => shared[name]()), ...describeFields(other.fields, values, of, prefix)].join(", ");
    }
    return `E ${of(`${prefix}young`)}, ν ${values[`${prefix}poisson`]}, ${hard}`;
  };
  const parts = [subjectOf(values)];
  if (["file", "example"].includes(values.surface) && values.form !== "none") parts.push(`less ${FORMS[values.form]}`);
  if (values.ball && values.surface !== "sphere") parts.push(`${values.added.replace("-", " along ")} of ${of("ball")}`);
  const load = {
    approach: `approach ${of("loads", "load_unit")}`,
    cycle: `approach from ${values.cycle_from} to ${of("cycle_to", "cycle_unit")} and back`,
    fretting: `normal force ${of("normal_force")}, tangential force ±${of("tangential_force")}, friction ${values.friction}`,
  };
  if (["file", "example"].includes(values.surface) && values.counterbody_surface === "file") parts.push(describeOther(values, of));
  parts.push(load[values.load] || of("loads", "load_unit"), ...(isPath(values) ? [describePath(values, of)] : []), material(""));
  if (values.counterbody === "deformable") parts.push(`counterbody ${material("counterbody_")}`);
  for (const [prefix, whose] of [["", "body"], ["counterbody_", "counterbody"]]) {
    for (let number = 1; number <= Number(values[`${prefix}layers`]); number += 1) {
      parts.push(`layer ${number} of the ${whose} ${of(`${prefix}layer${number}_thickness`)}, E ${of(`${prefix}layer${number}_young`)}`);
    }
  }
  if (values.adhesion !== "none") parts.push(`${values.adhesion.replaceAll("-", " ")} adhesion of ${of("work").replace("m2", "m²")}`);
  if (["exponential", "van-der-waals"].includes(values.adhesion)) parts.push(`range ${of("range")}`);
  const asked = ticked(values, "ask_");
  return [...parts, values.boundary].join(", ") + (asked.length ? `; with ${asked.join(", ")}` : "");
}
