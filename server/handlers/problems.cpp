#include "server/handlers/problems.h"

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>

#include "api/base/problem.h"

namespace meshgauge::server {
namespace {

// The texts of the table are plain in HTML.
void send_html(Exchange& exchange, const std::string& title, const std::string& content) {
  std::string page =
      "<!doctype html>\n<html lang=\"en\">\n<head><meta charset=\"utf-8\">"
      "<meta name=\"viewport\" content=\"width=device-width\"><meta name=\"color-scheme\" content=\"light dark\">"
      "<title>" +
      title + "</title></head>\n<body>\n<h1>" + title + "</h1>\n" + content + "</body>\n</html>\n";
  answer_with(exchange, std::move(page), 200, "text/html; charset=utf-8");
}

std::string link_to(const api::ProblemRow& row) {
  const std::string slug(row.slug);
  return "<a href=\"" + std::string(api::kProblemFolder) + slug + "\">" + slug + "</a>";
}

}  // namespace

void show_problem(Exchange& exchange) {
  const auto table = api::problem_table();
  const std::string_view slug = exchange.segment;
  const auto row = std::ranges::find(table, slug, &api::ProblemRow::slug);
  if (row == table.end()) {
    const api::Problem unknown{api::ProblemKind::not_found, "no problem has this name; /problems lists them"};
    return answer(exchange, unknown);
  }
  send_html(exchange, std::string(row->title),
            "<p><code>" + std::string(row->slug) + "</code>, HTTP status " + std::to_string(row->status) + "</p>\n<p>" +
                std::string(row->help) + "</p>\n<p><a href=\"/problems\">All problems</a></p>\n");
}

void list_problems(Exchange& exchange) {
  std::string list = "<dl>\n";
  for (const api::ProblemRow& row : api::problem_table())
    list += "<dt>" + link_to(row) + "</dt><dd>" + std::string(row.title) + "</dd>\n";
  send_html(exchange, "Problems of the service", list + "</dl>\n");
}

}  // namespace meshgauge::server
