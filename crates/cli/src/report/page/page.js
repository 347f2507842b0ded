"use strict";

// Viewer: two pictures one over the other, cut at the divider; one zoom moves both.
(() => {
  const byId = (id) => document.getElementById(id);
  if (!byId("viewer")) return;
  const figures = [...document.querySelectorAll("figure[data-label]")];
  const sides = ["left", "right"].map((name) => ({
    select: byId(name),
    image: byId(`${name}-image`),
    tag: byId(`${name}-tag`),
  }));
  const pane = byId("pane");
  const split = byId("split");
  const MOST_ZOOM = 16;
  const view = { zoom: 1, x: 0, y: 0 };
  let showsErrors = false;

  const showPictures = () => {
    for (const side of sides) {
      const figure = figures[side.select.value];
      const picture = figure.querySelector("img");
      const error = document.querySelector(`img[data-of="${picture.id}"]`);
      const shown = showsErrors ? error : picture;
      side.image.hidden = !shown;
      if (shown) {
        side.image.src = shown.src;
        side.image.alt = shown.alt;
      }
      side.tag.textContent = figure.dataset.label + (showsErrors ? (error ? ": error" : ": no error") : "");
    }
    pane.classList.toggle("errors", showsErrors);
    byId("legend").hidden = !showsErrors;
    byId("show-picture").setAttribute("aria-pressed", String(!showsErrors));
    byId("show-error").setAttribute("aria-pressed", String(showsErrors));
  };

  const showSplit = () => {
    // Both are cut: a transparent picture must not show the other one beneath it.
    byId("left-half").style.clipPath = `inset(0 ${100 - split.value}% 0 0)`;
    byId("right-half").style.clipPath = `inset(0 0 0 ${split.value}%)`;
    byId("divider").style.left = `${split.value}%`;
  };

  const showView = () => {
    const { width, height } = pane.getBoundingClientRect();
    view.x = Math.min(0, Math.max(view.x, width * (1 - view.zoom)));
    view.y = Math.min(0, Math.max(view.y, height * (1 - view.zoom)));
    for (const { image } of sides) {
      image.style.transform = `translate(${view.x}px, ${view.y}px) scale(${view.zoom})`;
    }
    pane.classList.toggle("zoomed", view.zoom > 1);
    byId("zoom-level").textContent = `${Number(view.zoom.toFixed(1))}×`;
  };

  // The point under (x, y) stays where it is.
  const zoomAt = (x, y, zoom) => {
    const next = Math.min(MOST_ZOOM, Math.max(1, zoom));
    view.x = x - ((x - view.x) * next) / view.zoom;
    view.y = y - ((y - view.y) * next) / view.zoom;
    view.zoom = next;
    showView();
  };
  const zoomAtMiddle = (zoom) => {
    const { width, height } = pane.getBoundingClientRect();
    zoomAt(width / 2, height / 2, zoom);
  };

  const placeOf = (event) => {
    const box = pane.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top, width: box.width };
  };

  let drag = null;
  pane.addEventListener("pointerdown", (event) => {
    const place = placeOf(event);
    const fromDivider = Math.abs(place.x - (place.width * split.value) / 100);
    const GRIP_PX = 24;
    drag = view.zoom > 1 && fromDivider > GRIP_PX ? { pans: true, x: place.x, y: place.y } : { pans: false };
    pane.setPointerCapture(event.pointerId);
    if (!drag.pans) moveDivider(place);
  });
  pane.addEventListener("pointermove", (event) => {
    if (!drag) return;
    const place = placeOf(event);
    if (!drag.pans) return moveDivider(place);
    view.x += place.x - drag.x;
    view.y += place.y - drag.y;
    drag = { pans: true, x: place.x, y: place.y };
    showView();
  });
  for (const end of ["pointerup", "pointercancel"]) pane.addEventListener(end, () => { drag = null; });
  const moveDivider = (place) => {
    split.value = (100 * place.x) / place.width;
    showSplit();
  };
  pane.addEventListener("wheel", (event) => {
    event.preventDefault();
    const { x, y } = placeOf(event);
    zoomAt(x, y, view.zoom * Math.exp(-event.deltaY * 0.002));
  }, { passive: false });

  figures.forEach((figure, index) => {
    for (const { select } of sides) select.add(new Option(figure.dataset.label, String(index)));
  });
  const right = Math.max(0, figures.findIndex((figure) => figure.classList.contains("reference")));
  const left = figures.findLastIndex((figure) => figure.dataset.aa === figures[right].dataset.aa);
  sides[0].select.value = String(left);
  sides[1].select.value = String(right);
  for (const { select } of sides) select.addEventListener("change", showPictures);
  split.addEventListener("input", showSplit);
  byId("show-picture").addEventListener("click", () => { showsErrors = false; showPictures(); });
  byId("show-error").addEventListener("click", () => { showsErrors = true; showPictures(); });
  byId("zoom-in").addEventListener("click", () => zoomAtMiddle(view.zoom * 2));
  byId("zoom-out").addEventListener("click", () => zoomAtMiddle(view.zoom / 2));
  byId("zoom-fit").addEventListener("click", () => zoomAtMiddle(1));
  window.addEventListener("resize", showView);
  byId("viewer").hidden = false;
  showPictures();
  showSplit();
  showView();
})();

// Tables: a heading sorts by its column, again the other way round. Missing figures stay last.
for (const table of document.querySelectorAll("table.sortable")) {
  const headings = [...table.tHead.rows[0].cells];
  headings.forEach((heading, column) => {
    heading.querySelector("button").addEventListener("click", () => {
      const ascending = heading.getAttribute("aria-sort") !== "ascending";
      headings.forEach((other) => other.removeAttribute("aria-sort"));
      heading.setAttribute("aria-sort", ascending ? "ascending" : "descending");
      const isNumber = heading.classList.contains("number");
      const key = (row) => {
        const cell = row.cells[column];
        if (!isNumber) return cell.textContent;
        return cell.dataset.value === "" ? NaN : Number(cell.dataset.value);
      };
      const compare = (a, b) => {
        const [x, y] = [key(a), key(b)];
        if (!isNumber) return x.localeCompare(y);
        if (Number.isNaN(x) || Number.isNaN(y)) return 0;
        return x - y;
      };
      const rows = [...table.tBodies[0].rows];
      const missing = rows.filter((row) => isNumber && Number.isNaN(key(row)));
      const present = rows.filter((row) => !missing.includes(row)).sort(compare);
      if (!ascending) present.reverse();
      table.tBodies[0].append(...present, ...missing);
    });
  });
}
