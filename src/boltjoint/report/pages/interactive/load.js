// Expand what the page holds compressed, the drawing library only when it is needed.
async function expand(id) {
  const text = document.getElementById(id).textContent;
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).text();
}

const expandJson = async (id) => JSON.parse(await expand(id));

let library = null;

function loadLibrary() {
  library = library || expand("plotly").then((text) => {
    const script = document.createElement("script");
    script.textContent = text;
    document.head.append(script);
  });
  return library;
}

// a file of text for the reader
function download(name, text, type) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text], { type }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

function downloadPicture(id, name) {
  const { width, height } = document.getElementById(id).getBoundingClientRect();
  return Plotly.downloadImage(id, { format: "png", filename: name, width, height, scale: 2 });
}

// a box to tick with its words
function tick(words, isTicked, onChange, colour) {
  const label = document.createElement("label");
  const input = Object.assign(document.createElement("input"), { type: "checkbox", checked: isTicked });
  input.addEventListener("change", () => onChange(input.checked));
  label.append(input);
  if (colour) {
    const swatch = document.createElement("i");
    swatch.style.background = colour;
    label.append(swatch);
  }
  label.append(words);
  return label;
}

function option(select, words, value) {
  select.add(new Option(words, value));
}
