// A field whose value is one of the files that the server keeps, with a button that opens another.
import {Refused, upload} from "/web/api.js";
import {element} from "/web/look.js";

/** Put "Open …" beside the list of a field. `path` and `more()` say where a file is sent; `chosen` is given its name once it is kept. Returns the input of files. */
export function opener(field, {id, accept, title, path, more = () => ({}), chosen}) {
  const {input: list} = field, note = element("p", {className: "about", role: "status"});
  const input = element("input", {type: "file", id, className: "unseen", accept});
  const entry = element("span", {className: "row"});
  list.replaceWith(entry);
  entry.append(list, element("label", {htmlFor: id, className: "button", title}, "Open …", input));
  entry.parentElement.append(note);
  input.addEventListener("change", async () => {
    if (input.files.length) note.textContent = await kept(input.files[0]);
    input.value = "";
  });

  /** Send a file, choose it, and return what the server understood of it. */
  async function kept(file) {
    try {
      const {name, sentence} = await upload(file, path, more());
      if (![...list.options].some(({value}) => value === name)) list.append(element("option", {value: name}, name));
      await chosen(name);
      return sentence;
    } catch (error) {
      if (!(error instanceof Refused)) throw error;
      return error.message;
    }
  }
  return input;
}
