// /docs: openapi.yaml in a form to be read and tried, by swagger-ui, from files of the binary's own.
#pragma once

#include "server/exchange.h"

namespace meshgauge::server {

void show_reference(Exchange& exchange);       // the page
void send_reference_file(Exchange& exchange);  // what it loads: the route's segment names it

}  // namespace meshgauge::server
