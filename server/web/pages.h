// The pages of the service: /, which measures and shows, and /docs, which is openapi.yaml by swagger-ui. Both from the
// binary's own files (assets.h); they load nothing from elsewhere, and their policy lets them load nothing else.
#pragma once

#include "server/http/exchange.h"

namespace meshgauge::server {

bool has_pages();  // whether the binary was built with them

void show_root(Exchange& exchange);            // the page, or a line of text for who would rather have text
void send_page_file(Exchange& exchange);       // what the page loads: the route's segment names it
void show_reference(Exchange& exchange);       // /docs
void send_reference_file(Exchange& exchange);  // what it loads

// The page of a comparison or a batch, for any id that could be one, whether or not it is; of another id as below.
void show_permanent_link(Exchange& exchange);

// A link that has no id, or something behind it: 404, as the page, which says what is wrong, for who prefers text/html
// to JSON; else a problem.
void show_damaged_link(Exchange& exchange);

}  // namespace meshgauge::server
