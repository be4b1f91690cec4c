// Replaced by the page's camera.js.
