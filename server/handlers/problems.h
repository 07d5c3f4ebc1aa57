// Pages about the kinds of problems, which the `type` of each problem leads to.
#pragma once

#include "server/http/exchange.h"

namespace meshgauge::server {

void show_problem(Exchange& exchange);   // /problems/{}: what the kind means and what to do; 404 if there is none
void list_problems(Exchange& exchange);  // /problems: all of them

}  // namespace meshgauge::server
