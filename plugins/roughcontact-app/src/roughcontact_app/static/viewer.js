// A picture that can be zoomed and moved by wheel, buttons, keys, mouse and two fingers.

const MOST = 16;

export class Viewer {
  constructor(place, label) {
    this.place = place;
    this.frame = document.createElement("div");
    this.frame.className = "frame";
    this.frame.tabIndex = 0;
    this.frame.setAttribute("role", "group");
    this.frame.setAttribute("aria-label", `${label}. Plus and minus zoom, arrows move, 0 shows all; the wheel zooms after a click.`);
    this.image = document.createElement("img");
    this.image.draggable = false;
    this.frame.append(this.image);
    this.problem = document.createElement("p");
    this.problem.className = "alert";
    this.problem.hidden = true;
    this.problem.setAttribute("role", "alert");
    this.image.addEventListener("load", () => this.frame.classList.remove("skeleton"));
    this.image.addEventListener("error", () => this.fail());
    this.scaleText = document.createElement("span");
    this.scaleText.className = "help";
    place.replaceChildren(this.problem, this.frame, this.makeButtons());
    this.pointers = new Map();
    this.listen();
    this.reset();
  }

  // Another picture of the same kind may keep what is zoomed in; until it is here, there is a blank in its place.
  show(address, text, keepsView = false) {
    if (this.image.getAttribute("src") !== address) {
      this.frame.classList.toggle("skeleton", !keepsView);
      this.image.src = address;
    }
    this.image.alt = text;
    this.problem.hidden = true;
    this.frame.hidden = this.place.hidden = false;
    if (!keepsView) this.reset();
  }

  // The picture may be asked for again: its tab opened anew.
  async fail() {
    const address = this.image.getAttribute("src");
    if (!address) return;
    const { error = "" } = await fetch(address).then((answer) => answer.json()).catch(() => ({}));
    if (this.image.getAttribute("src") !== address) return;
    this.image.removeAttribute("src");
    this.problem.textContent = error || "This picture could not be drawn.";
    this.problem.hidden = false;
    this.frame.hidden = true;
  }

  hide() {
    this.place.hidden = true;
  }

  makeButtons() {
    const row = document.createElement("div");
    row.className = "buttons";
    const actions = [
      ["+", "Zoom in", () => this.zoom(1.5)],
      ["−", "Zoom out", () => this.zoom(1 / 1.5)],
      ["⤢", "Show all", () => this.reset()],
    ];
    for (const [text, label, act] of actions) {
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = text;
      button.title = label;
      button.setAttribute("aria-label", label);
      button.addEventListener("click", act);
      row.append(button);
    }
    row.append(this.scaleText);
    return row;
  }

  listen() {
    const frame = this.frame;
    frame.addEventListener("wheel", (event) => {
      // A page that scrolls past the picture must not be caught by it.
      if (!event.ctrlKey && !event.metaKey && document.activeElement !== frame) return;
      event.preventDefault();
      this.zoom(Math.exp(-event.deltaY / 300), ...this.place_of(event));
    }, { passive: false });
    frame.addEventListener("keydown", (event) => {
      const step = 60;
      const acts = {
        "+": () => this.zoom(1.5), "=": () => this.zoom(1.5), "-": () => this.zoom(1 / 1.5), 0: () => this.reset(),
        ArrowLeft: () => this.move(step, 0), ArrowRight: () => this.move(-step, 0),
        ArrowUp: () => this.move(0, step), ArrowDown: () => this.move(0, -step),
      };
      if (event.ctrlKey || event.metaKey || event.altKey || !(event.key in acts)) return;
      event.preventDefault();
      acts[event.key]();
    });
    frame.addEventListener("dblclick", (event) => this.zoom(2, ...this.place_of(event)));
    frame.addEventListener("pointerdown", (event) => {
      frame.setPointerCapture(event.pointerId);
      frame.classList.add("dragged");
      this.pointers.set(event.pointerId, this.place_of(event));
    });
    frame.addEventListener("pointermove", (event) => this.drag(event));
    for (const end of ["pointerup", "pointercancel"]) {
      frame.addEventListener(end, (event) => {
        this.pointers.delete(event.pointerId);
        if (!this.pointers.size) frame.classList.remove("dragged");
      });
    }
  }

  place_of(event) {
    const box = this.frame.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }

  drag(event) {
    const before = this.pointers.get(event.pointerId);
    if (!before) return;
    const now = this.place_of(event);
    const other = [...this.pointers].find(([id]) => id !== event.pointerId);
    if (other) {
      const apart = (one) => Math.hypot(one[0] - other[1][0], one[1] - other[1][1]);
      const centre = [(now[0] + other[1][0]) / 2, (now[1] + other[1][1]) / 2];
      if (apart(before) > 0) this.zoom(apart(now) / apart(before), ...centre);
    } else {
      this.move(now[0] - before[0], now[1] - before[1]);
    }
    this.pointers.set(event.pointerId, now);
  }

  // About a point of the frame, its centre by default, which stays where it is.
  zoom(factor, x = this.frame.clientWidth / 2, y = this.frame.clientHeight / 2) {
    const scale = Math.min(MOST, Math.max(1, this.scale * factor));
    this.x = x - ((x - this.x) * scale) / this.scale;
    this.y = y - ((y - this.y) * scale) / this.scale;
    this.scale = scale;
    this.apply();
  }

  move(dx, dy) {
    this.x += dx;
    this.y += dy;
    this.apply();
  }

  reset() {
    Object.assign(this, { scale: 1, x: 0, y: 0 });
    this.apply();
  }

  apply() {
    const { clientWidth: width, clientHeight: height } = this.frame;
    this.x = Math.min(0, Math.max(this.x, width * (1 - this.scale)));
    this.y = Math.min(0, Math.max(this.y, height * (1 - this.scale)));
    this.image.style.transform = `translate(${this.x}px, ${this.y}px) scale(${this.scale})`;
    // A finger moves what is zoomed in, and otherwise scrolls the page.
    this.frame.classList.toggle("zoomed", this.scale > 1);
    this.image.style.imageRendering = this.scale > 3 ? "pixelated" : "auto";
    this.scaleText.textContent = this.scale > 1 ? `${this.scale.toFixed(1)} times` : "";
  }
}
