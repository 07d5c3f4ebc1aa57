// No plugin that asks a service elsewhere, and a description from here alone: the page's policy allows nothing else.
SwaggerUIBundle({
  dom_id: "#reference",
  url: "openapi.yaml",
  validatorUrl: null,
  queryConfigEnabled: false,
  deepLinking: true,
  defaultModelsExpandDepth: 0,
});
