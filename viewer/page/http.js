// Replaced by the page's http.js.
