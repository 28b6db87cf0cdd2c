// The range input does the work; this only tells the picture where it stands.
for (const slider of document.querySelectorAll(".slider")) {
  const range = slider.querySelector("input");
  const show = () => slider.style.setProperty("--at", `${range.value}%`);
  range.addEventListener("input", show);
  show(); // A browser that reloads a page may restore the value.
}
