// Replaced by the page's view.js.
