// Handlers of the pages: /, on which meshes are compared, and /docs, which shows openapi.yaml by swagger-ui. Both come
// from the binary (embedded.h), and their content security policy allows no other origin.
#pragma once

#include "server/http/exchange.h"

namespace meshgauge::server {

bool has_pages();  // false: the binary was built without them

void show_root(Exchange& exchange);            // /: the page; plain text if the client prefers text/plain
void send_page_file(Exchange& exchange);       // /page/{}: a file that the page loads
void show_reference(Exchange& exchange);       // /docs
void send_reference_file(Exchange& exchange);  // /docs/{}: a file that /docs loads
void send_description(Exchange& exchange);     // /openapi.yaml
void send_gates_schema(Exchange& exchange);    // /gates.schema.json: of the manifests of `meshgauge check`

// /c/{} and /b/{}: the page of a comparison or a batch. Any well-formed id gets the page, which then asks for it;
// another one as show_damaged_link().
void show_permanent_link(Exchange& exchange);

// A link without an id, or with text after it: 404. The body is the page, which explains it, if the client prefers
// text/html to JSON; else a problem.
void show_damaged_link(Exchange& exchange);

}  // namespace meshgauge::server
