// A height map that the user chooses or drops: the file that is being read, what it states, and what a link asks for.

import { post, upload } from "./api.js";
import { byId, say } from "./page.js";
import * as settings from "./settings.js";

const wishFor = ({ name, digest }) => `Choose or drop the file of this link again: ${name}, digest ${digest.slice(0, 12)}.`;

export class MapFile {
  // The prefix is that of its settings and places; kind is the setting that says whether the map is solved.
  constructor(prefix, kind, onChange, onChoose) {
    Object.assign(this, { prefix, kind, onChange });
    this.input = byId(`${prefix}file-input`);
    this.input.addEventListener("change", () => onChoose(this, [...this.input.files]));
    this.forget();
  }

  forget() {
    Object.assign(this, { facts: null, reading: null, unread: "", wanted: null });
  }

  get isMissing() {
    return Boolean(this.reading || (this.unread && settings.isFile(this.kind)));
  }

  say(text) {
    say(`${this.prefix}file-shown`, text);
  }

  // What was shown before is of another surface: it goes at once, and answers on their way are dropped.
  async take(file) {
    this.reading = file;
    for (const place of ["refusal", "note"]) say(place, "");
    byId(`g-${this.prefix ? "counterbody" : "surface"}`).open = true;
    this.say(`Reading ${file.name} ...`);
    this.onChange();
    try {
      const found = await upload(file, this.prefix);
      if (this.reading === file) this.accept(found);
    } catch (error) {
      if (this.reading === file) this.refuse(file.name, error.message);
    }
  }

  accept(found) {
    const { wanted, prefix } = this;
    const other = wanted && wanted.digest !== found.digest;
    // What a link says of its file holds for the file that is chosen for it.
    if (!wanted && settings.read()[`${prefix}file`] !== found.digest) {
      for (const name of ["non_measured", "rows"]) settings.reset(`${prefix}${name}`);
    }
    this.forget();
    this.facts = found.facts;
    settings.setFile(prefix, found.digest, found.name);
    this.show(found, other ? ` It is not the file of the link, ${wanted.name}, whose digest begins ${wanted.digest.slice(0, 12)}.` : "");
    this.solve();
  }

  refuse(name, problem) {
    const { wanted } = this;
    Object.assign(this, { facts: null, reading: null, unread: problem });
    settings.setFile(this.prefix, wanted?.digest || "", wanted?.name || name);
    this.say(wanted ? wishFor(wanted) : "");
    this.solve();
  }

  solve() {
    const kind = settings.form.elements[this.kind];
    if (kind.value !== "file") {
      kind.value = "file";
      if (this.kind === "surface") say("boundary-note", settings.surfaceKindChanged());
    }
    this.onChange();
  }

  show(found, more = "") {
    const cells = found.facts ? `, ${found.facts.shape.join(" x ")} points` : "";
    this.say(`${found.name}${cells}, digest ${found.digest.slice(0, 12)}.${more}`);
  }

  // Takes up the file of settings that a link has brought; returns what to say of it.
  async restore() {
    this.forget();
    const { [`${this.prefix}file`]: digest, [`${this.prefix}file_name`]: name } = settings.read();
    const known = settings.isFile(this.kind) && digest ? await post(`api/file?body=${this.prefix}`, digest).catch(() => ({ here: false })) : null;
    this.say("");
    if (known?.here) {
      this.facts = known.facts;
      this.show(known);
    } else if (known) {
      this.wanted = { name, digest };
      this.say(wishFor(this.wanted));
    }
    return this.wanted ? wishFor(this.wanted) : "";
  }
}
