#include "cli/mcp/session.h"

#include <algorithm>
#include <cstddef>
#include <exception>
#include <iterator>
#include <memory>
#include <new>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "api/base/json_filter.h"
#include "api/base/text.h"
#include "check/html/markup.h"
#include "engine/hausdorff.h"

namespace meshgauge::mcp {
namespace {

// Revisions of the protocol, the newest first. They differ in nothing that is used here. 2025-03-26 is left out: it has
// batches, which it must be possible to receive.
constexpr std::string_view kRevisions[] = {"2025-11-25", "2025-06-18", "2024-11-05"};
constexpr const Tool* kTools[] = {&kCompareMeshes, &kInspectMesh, &kCheckGates};
constexpr std::string_view kMethods[] = {"initialize", "ping", "tools/list", "tools/call"};
constexpr const char* kInstructions =
    "Judges triangle meshes, such as those that a CAD program wrote: compare_meshes measures how far a candidate is "
    "from a reference and answers pass, fail or undecided with the point that is farthest off; inspect_mesh says "
    "whether a mesh is closed and how large it is; check_gates runs the checks of a gates.yaml. Files are read below "
    "the roots of the server only.";

const Tool* tool_of(const std::string& name) {
  const auto* const found = std::ranges::find_if(kTools, [&](const Tool* tool) { return tool->name == name; });
  return found == std::end(kTools) ? nullptr : *found;
}

std::vector<std::string_view> tool_names() {
  std::vector<std::string_view> names;
  for (const Tool* tool : kTools) names.push_back(tool->name);
  return names;
}

Json initialized(const std::string& asked) {
  const auto* const known = std::ranges::find(kRevisions, std::string_view(asked));
  return {{"protocolVersion", known == std::end(kRevisions) ? kRevisions[0] : *known},
          {"capabilities", {{"tools", Json::object()}}},
          {"serverInfo", {{"name", "meshgauge"}, {"title", "meshgauge"}, {"version", version()}}},
          {"instructions", kInstructions}};
}

Json list_of_tools() {
  Json tools = Json::array();
  for (const Tool* tool : kTools) {
    tools.push_back({{"name", tool->name},
                     {"title", tool->title},
                     {"description", tool->description},
                     {"inputSchema", tool->input()},
                     {"outputSchema", tool->output()},
                     {"annotations", {{"readOnlyHint", true}, {"idempotentHint", true}, {"openWorldHint", false}}}});
  }
  return {{"tools", std::move(tools)}};
}

// Clients that know no structured content get it as text, too.
Json result_of(const ToolAnswer& answer) {
  Json content = Json::array({{{"type", "text"}, {"text", answer.text}}});
  if (answer.found.is_null()) return {{"content", std::move(content)}, {"isError", true}};
  content.push_back({{"type", "text"}, {"text", answer.found.dump(-1, ' ', false, Json::error_handler_t::replace)}});
  if (!answer.png.empty())
    content.push_back({{"type", "image"}, {"data", check::base64(answer.png)}, {"mimeType", "image/png"}});
  return {{"content", std::move(content)}, {"structuredContent", answer.found}, {"isError", false}};
}

// Null: the client wants no progress.
nlohmann::json progress_token(const nlohmann::json& params) {
  const auto meta = params.find("_meta");
  if (meta == params.end() || !meta->is_object()) return nullptr;
  const auto token = meta->find("progressToken");
  return token == meta->end() || text_of_id(*token).empty() ? nlohmann::json() : *token;
}

}  // namespace

Session::Session(Context context, unsigned threads, Send send)
    : context_(std::move(context)),
      send_(std::move(send)),
      calls_(threads, {256, 4 * kMostMessageBytes},
             [this](std::string answer) { send_(std::move(answer), Line::answer); }) {}

void Session::receive(std::string_view line) try {
  if (api::trimmed(line).empty()) return;
  Received received = read_message(line);
  if (const auto* refusal = std::get_if<Refusal>(&received)) return send_(refusal_line(*refusal), Line::answer);
  if (auto* request = std::get_if<Request>(&received)) take(std::move(*request), line.size());
} catch (const std::bad_alloc&) {
  refuse(kBusy, "there is not enough memory for this message: wait for an answer, or send a smaller one", id_in(line));
}

void Session::refuse_long(const std::string& id) {
  refuse(kInvalidMessage,
         "the message is longer than " + std::to_string(kMostMessageBytes) +
             " bytes, or than there is memory for: write meshes to files, and give their paths",
         id);
}

void Session::refuse(int code, const std::string& message, const std::string& id) const {
  send_(refusal_line({code, message, id}), Line::answer);
}

void Session::take(Request request, std::size_t bytes) {
  if (request.id.empty()) return notified(request);
  if (request.method == "ping") return send_(answer_line(request.id, Json::object()), Line::answer);
  if (request.method == "tools/call") return call_tool(std::move(request), bytes);
  if (request.method == "tools/list") {
    if (request.params.contains("cursor"))
      return refuse(kInvalidParams, "there is no such cursor: the list is one page", request.id);
    return send_(answer_line(request.id, list_of_tools()), Line::answer);
  }
  if (request.method == "initialize") {
    const auto asked = request.params.find("protocolVersion");
    if (asked == request.params.end() || !asked->is_string())
      return refuse(kInvalidParams, "protocolVersion must be a text such as \"" + std::string(kRevisions[0]) + "\"",
                    request.id);
    return send_(answer_line(request.id, initialized(asked->get<std::string>())), Line::answer);
  }
  refuse(kUnknownMethod, "there is no method " + api::shown_text(request.method) + "; known: " + api::listed(kMethods),
         request.id);
}

void Session::notified(const Request& request) {
  if (request.method != "notifications/cancelled") return;
  const auto id = request.params.find("requestId");
  if (id != request.params.end()) calls_.cancel(text_of_id(*id));
}

void Session::call_tool(Request request, std::size_t bytes) {
  const std::string id = request.id;
  const auto name = request.params.find("name"), arguments = request.params.find("arguments");
  if (name == request.params.end() || !name->is_string())
    return refuse(kInvalidParams, "name must be that of a tool: " + api::listed(tool_names()), id);
  const Tool* const tool = tool_of(name->get_ref<const std::string&>());
  if (!tool)
    return refuse(kInvalidParams,
                  "there is no tool " + api::shown_text(name->get_ref<const std::string&>()) +
                      "; known: " + api::listed(tool_names()),
                  id);
  if (arguments != request.params.end() && !arguments->is_object())
    return refuse(kInvalidParams, "arguments must be an object, not " + api::shown(*arguments), id);
  const auto own = std::make_shared<Request>(std::move(request));
  const auto begun =
      calls_.begin(id, bytes, [this, tool, own](Control& control) { return answer_of(*tool, *own, control); });
  if (begun == Calls::Begun::same_id) refuse(kInvalidMessage, "a call with the id " + id + " is still running", id);
  if (begun == Calls::Begun::too_many) refuse(kBusy, "too many calls at once: wait for an answer, then call again", id);
}

std::string Session::answer_of(const Tool& tool, Request& request, Control& control) const {
  const auto failed = [&](const std::string& why) {
    return answer_line(request.id, result_of(failure(Error{ErrorCode::internal, why, "", ""})));
  };
  try {
    return answer_line(request.id, result_of(run(tool, request, control)));
  } catch (const std::bad_alloc&) {
    return failed("there is not enough memory for this call");
  } catch (const std::exception& error) {
    return failed(std::string("the call failed unexpectedly: ") + error.what());
  }
}

ToolAnswer Session::run(const Tool& tool, Request& request, Control& control) const {
  const auto others = static_cast<unsigned>(std::max<std::size_t>(1, calls_.running()));
  ToolCall call{nlohmann::json::object(), control, std::max(1U, context_.processors / others)};
  const auto arguments = request.params.find("arguments");
  if (arguments != request.params.end()) call.arguments = std::move(*arguments);
  if (const nlohmann::json token = progress_token(request.params); !token.is_null()) {
    call.progress = [this, token, &control](double done, double all, const std::string& what) {
      if (control.cancelled()) return;
      Json params{{"progressToken", Json(token)}, {"progress", done}};
      if (all > 0) params["total"] = all;
      params["message"] = what;
      send_(notification_line("notifications/progress", params), Line::progress);
    };
  }
  return tool.run(context_, call);
}

}  // namespace meshgauge::mcp
