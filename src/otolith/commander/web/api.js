// Requests to the server. What it refuses is thrown as one sentence with the field it is about.

export class Refused extends Error {
  constructor(sentence, field, status) {
    super(sentence);
    this.field = field;
    this.status = status;
  }
}

let csrf = "";

async function request(method, path, body, raw = false) {
  const headers = {"X-Otolith": csrf};
  if (body !== undefined && !raw) headers["Content-Type"] = "application/json";
  const options = {method, headers, keepalive: method === "POST" && !raw};
  if (body !== undefined) options.body = raw ? body : JSON.stringify(body);
  let answer;
  try {
    answer = await fetch(path, options);
  } catch {
    throw new Refused("the server does not answer", undefined, 0);
  }
  const text = await answer.text();
  const content = text && answer.headers.get("content-type")?.includes("json") ? JSON.parse(text) : {};
  if (!answer.ok) throw new Refused(content.sentence ?? `the server refused (${answer.status})`, content.field, answer.status);
  return content;
}

export const get = (path) => request("GET", path);
export const post = (path, body = {}) => request("POST", path, body);
export const put = (path, body) => request("PUT", path, body);
export const remove = (path) => request("DELETE", path);
/** Send a file to a path, with what else the path needs; the server keeps it by its name. */
export const upload = (file, path = "/api/upload", more = {}) => request("POST", `${path}?${new URLSearchParams({name: file.name, ...more})}`, file, true);

/** Fetch what there is to choose from; must come before any other request. */
export async function start() {
  const content = await get("/api/start");
  csrf = content.csrf;
  return content;
}
