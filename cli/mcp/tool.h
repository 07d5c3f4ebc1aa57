// A tool: what a client sees of it, and what runs when it is called.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "api/compare/load.h"
#include "api/compare/mesh_file.h"
#include "api/options/reading.h"
#include "api/options/request.h"
#include "api/options/surface.h"
#include "cli/mcp/message.h"
#include "engine/control.h"
#include "engine/result.h"

namespace meshgauge::mcp {

// The bytes of a mesh that is sent inside of a message. A message may hold two, as base64, and some text.
inline constexpr std::size_t kMostInlineBytes = std::size_t{16} << 20;
inline constexpr std::size_t kMostMessageBytes = 2 * (kMostInlineBytes / 3 + 1) * 4 + (std::size_t{1} << 20);

// What calls may read and use.
struct Context {
  std::shared_ptr<const api::Confines> confines;
  unsigned processors = 1;
  api::RequestLimits times{};
};

// One call, on the thread that runs it.
struct ToolCall {
  nlohmann::json arguments;  // an object
  Control& control;
  unsigned threads = 1;  // that it may use
  // Tells the client how far it is: `done`, which never falls, of `all`; 0: that is not known. May be empty.
  std::function<void(double done, double all, const std::string& what)> progress{};
};

struct ToolAnswer {
  std::string text;            // what was found, in sentences; of a failure why there is nothing
  Json found;                  // by Tool::output; null: a failure
  std::vector<std::byte> png;  // empty: no picture
};

struct Tool {
  std::string_view name, title, description;
  Json (*input)();   // JSON Schema of the arguments
  Json (*output)();  // of ToolAnswer::found
  // Returns when the work is done or cancelled. Does not throw, but std::bad_alloc.
  ToolAnswer (*run)(const Context& context, ToolCall& call);
};

extern const Tool kCompareMeshes, kInspectMesh, kCheckGates;

// --- what tools share -----------------------------------------------------------------------------------------------

// Names of arguments in messages are JSON pointers.
extern const api::Surface kArguments;

// Puts the criterion of this name, which may be null, before the others of a list.
void put_first(Json& criteria, const Json& name);

ToolAnswer failure(const Error& error);
ToolAnswer failure(const std::vector<api::RequestMistake>& mistakes);  // a line for each, with its pointer

// Returns a schema of an object with these properties and no others.
Json object_schema(Json properties, const std::vector<std::string>& required);
// Returns {"type": "string", "description": ...} or the like.
Json schema_of(const Json& type, std::string_view description);

// A mesh as a client names it: {"path": ...}, or {"base64": ...} with or without a "name".
struct MeshArgument {
  std::string path;  // empty: the bytes are given
  std::string name;
  std::vector<std::byte> bytes;
};
Json mesh_schema(std::string_view description);
// Reads one; a mistake is added to those of `reading`.
MeshArgument read_mesh_argument(const nlohmann::json& value, const std::string& at, api::Reading& reading);

// The file of such a mesh.
class GivenMesh {
 public:
  // `part`: the mesh's name in messages, unless it has a path or a name. Errors: those of MeshFile::open_within().
  static Result<GivenMesh> open(MeshArgument argument, const std::string& part, const api::Confines& confines);

  const std::string& name() const { return name_; }
  api::MeshInput input() const;  // borrows this object

 private:
  GivenMesh() = default;

  std::string name_;
  std::string filename_;
  std::vector<std::byte> bytes_;
  std::optional<api::MeshFile> file_;
};

}  // namespace meshgauge::mcp
