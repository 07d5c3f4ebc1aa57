// Where the page begins.
const host = document.getElementById("page");
if (host) host.dataset["path"] = location.pathname;
