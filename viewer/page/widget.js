// Replaced by the page's widget.js.
