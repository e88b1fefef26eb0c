// Requests to the server: all paths are relative, below the token of the link.

// Names this tab, whose readings do not wait for those of others.
const page = (sessionStorage.page ||= crypto.randomUUID());

async function answerOf(response) {
  const data = await response.json();
  if (!response.ok) throw Object.assign(new Error(data.error || "The server refused this."), { setting: data.setting || "" });
  return data;
}

async function request(path, options) {
  let response;
  try {
    response = await fetch(path, { ...options, headers: { ...options.headers, "X-Page": page } });
  } catch {
    throw new Error("The server does not answer: is 'roughcontact app' still running?");
  }
  return answerOf(response);
}

export const get = (path) => request(path, {});

export const post = (path, data) =>
  request(path, { method: "POST", body: JSON.stringify(data), headers: { "Content-Type": "application/json" } });

// The prefix is that of the settings of the body that the file is for: each body's file is read for itself.
export const upload = (file, prefix) =>
  request(`api/upload?name=${encodeURIComponent(file.name)}&body=${prefix}`, { method: "POST", body: file });
