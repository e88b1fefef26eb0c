// Parts of the page that all its scripts need.

export const byId = (name) => document.getElementById(name);

export function element(name, text = "", attributes = {}) {
  const made = document.createElement(name);
  made.textContent = text;
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  return made;
}

export function say(place, text) {
  byId(place).hidden = !text;
  byId(place).textContent = text;
}

export function showList(place, texts) {
  place.hidden = !texts.length;
  place.replaceChildren(...texts.map((text) => element("li", text)));
}
