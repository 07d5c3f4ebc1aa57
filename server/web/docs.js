// No validator service, and no description from another origin: the page's policy would block both.
SwaggerUIBundle({
  dom_id: "#reference",
  url: "openapi.yaml",
  validatorUrl: null,
  queryConfigEnabled: false,
  deepLinking: true,
  defaultModelsExpandDepth: 0,
});
