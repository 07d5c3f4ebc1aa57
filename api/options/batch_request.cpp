#include "api/options/batch_request.h"

#include <algorithm>
#include <initializer_list>
#include <unordered_map>
#include <utility>

#include <nlohmann/json.hpp>

#include "api/base/json_filter.h"
#include "api/base/refused.h"
#include "api/base/text.h"
#include "api/base/utf8.h"

namespace meshgauge::api {
namespace {

using JsonValue = nlohmann::json;

std::string dumped(const JsonValue& json) { return json.dump(-1, ' ', false, JsonValue::error_handler_t::replace); }

class BatchReader {
 public:
  BatchReader(const std::string& document, const BatchLimits& limits) : document_(document), limits_(limits) {}

  Result<BatchRequest> read(const JsonValue& json) {
    if (auto fine = members(json, "", {"name", "options", "comparisons"}); !fine) return fine.error();
    if (auto fine = text(json, "", batch_.name); !fine) return fine.error();
    if (auto fine = object(json, "options", ""); !fine) return fine.error();
    common_ = json.value("options", JsonValue::object());
    const auto pairs = json.find("comparisons");
    if (pairs == json.end()) return invalid("/comparisons", "/comparisons is missing");
    if (!pairs->is_array() || pairs->empty()) {
      return invalid("/comparisons", "/comparisons must be an array of at least one comparison");
    }
    if (pairs->size() > limits_.max_pairs) {
      return Error{ErrorCode::too_large,
                   "the batch has " + std::to_string(pairs->size()) + " comparisons, more than the limit of " +
                       std::to_string(limits_.max_pairs),
                   document_, "/comparisons"};
    }
    batch_.pairs.reserve(pairs->size());
    for (const JsonValue& pair : *pairs) {
      if (auto fine = add(pair, "/comparisons/" + std::to_string(batch_.pairs.size())); !fine) return fine.error();
    }
    return std::move(batch_);
  }

  Result<StoredPair> read_pair(const JsonValue& json) const {
    if (auto fine = members(json, "", {"a", "b", "options"}); !fine) return fine.error();
    BatchMesh a, b;
    if (auto fine = mesh(json, "a", "", a); !fine) return fine.error();
    if (auto fine = mesh(json, "b", "", b); !fine) return fine.error();
    return StoredPair{a.id, b.id, dumped(json.value("options", JsonValue::object()))};
  }

 private:
  Error invalid(const std::string& where, std::string message) const {
    return refused(std::move(message), document_, where);
  }

  Result<Done> members(const JsonValue& json, const std::string& pointer,
                       std::initializer_list<const char*> known) const {
    const std::string name = pointer.empty() ? "the document" : pointer;
    if (!json.is_object()) return invalid(pointer, name + " must be an object, not " + shown(json));
    for (const auto& [key, member] : json.items()) {
      if (std::find(known.begin(), known.end(), key) != known.end()) continue;
      return invalid(pointer + "/" + key, "unknown member " + shown_text(key) + "; known: " + listed(known));
    }
    return Done{};
  }

  Result<Done> object(const JsonValue& json, const char* key, const std::string& pointer) const {
    const auto found = json.find(key);
    if (found == json.end() || found->is_object()) return Done{};
    const std::string where = pointer + "/" + key;
    return invalid(where, where + " must be an object, not " + shown(*found));
  }

  // Names appear in documents and reports, where control characters are not allowed.
  Result<Done> short_text(const JsonValue& json, const std::string& where, std::string& out) const {
    if (json.is_string()) {
      const auto& text = json.get_ref<const std::string&>();
      const bool fine = !text.empty() && text.size() <= kMaxBatchNameBytes;
      if (fine && find_control(text) == std::string::npos) {
        out = text;
        return Done{};
      }
    }
    return invalid(where, where + " must be a string of 1 to " + std::to_string(kMaxBatchNameBytes) +
                              " bytes without control characters");
  }

  Result<Done> text(const JsonValue& json, const std::string& pointer, std::string& out) const {
    const auto found = json.find("name");
    return found == json.end() ? Done{} : short_text(*found, pointer + "/name", out);
  }

  Result<Done> mesh(const JsonValue& pair, const char* key, const std::string& pointer, BatchMesh& out) const {
    const std::string where = pointer + "/" + key;
    const auto found = pair.find(key);
    if (found == pair.end()) return invalid(where, where + " is missing");
    if (found->is_string() && is_mesh_id(found->get_ref<const std::string&>())) {
      out.id = found->get<std::string>();
      return Done{};
    }
    const char* or_part = limits_.parts ? ", or {\"part\": NAME}" : "";
    if (!limits_.parts || !found->is_object()) {
      return invalid(where, where + " must be the id of a stored mesh, 64 lower-case hex digits" + or_part + ", not " +
                                shown(*found));
    }
    if (auto fine = members(*found, where, {"part"}); !fine) return fine;
    if (!found->contains("part")) return invalid(where + "/part", where + "/part is missing");
    return short_text((*found)["part"], where + "/part", out.part);
  }

  Result<Done> add(const JsonValue& json, const std::string& pointer) {
    if (auto fine = members(json, pointer, {"name", "a", "b", "options"}); !fine) return fine;
    BatchPair pair;
    if (auto fine = text(json, pointer, pair.name); !fine) return fine;
    if (auto fine = mesh(json, "a", pointer, pair.a); !fine) return fine;
    if (auto fine = mesh(json, "b", pointer, pair.b); !fine) return fine;
    if (auto fine = object(json, "options", pointer); !fine) return fine;
    const auto own = json.find("options");
    auto options = options_of(own == json.end() ? JsonValue::object() : *own, pointer);
    if (!options) return options.error();
    pair.options = *options;
    batch_.pairs.push_back(std::move(pair));
    return Done{};
  }

  // Returns the index of the merged options. Most comparisons share their options, so each distinct text is parsed
  // once.
  Result<std::size_t> options_of(const JsonValue& own, const std::string& pointer) {
    if (own.empty() && common_known_) return *common_known_;
    JsonValue merged = common_;
    for (const auto& [key, member] : own.items()) merged[key] = member;
    const auto [known, added] = known_.try_emplace(dumped(merged), batch_.options.size());
    if (added) {
      if (auto read = parse_options(known->first, limits_.request); !read) return placed(read.error(), own, pointer);
      batch_.options.push_back(known->first);
    }
    if (own.empty()) common_known_ = known->second;
    return known->second;
  }

  // Moves errors in options to their places in the document.
  Error placed(Error error, const JsonValue& own, const std::string& pointer) const {
    for (Error& other : error.others) other = placed(other, own, pointer);
    const std::string member = error.where.substr(0, error.where.find('/', 1));
    const bool is_own = !own.empty() && (member.empty() || own.contains(member.substr(1)));
    error.where = (is_own ? pointer : std::string()) + "/options" + error.where;
    error.part = document_;
    return error;
  }

  const std::string& document_;
  const BatchLimits& limits_;
  BatchRequest batch_;
  JsonValue common_;  // options of the batch
  std::optional<std::size_t> common_known_;
  std::unordered_map<std::string, std::size_t> known_;
};

}  // namespace

bool is_mesh_id(std::string_view text) { return is_lower_hex(text, 64); }

Result<StoredPair> parse_stored_pair(std::string_view json) {
  const std::string document = "body";
  const auto tree = parse_document(json, document, kMaxOptionsBytes);
  if (!tree) return tree.error();
  return BatchReader(document, {}).read_pair(*tree);
}

Result<BatchRequest> parse_batch(std::string_view json, const std::string& document, const BatchLimits& limits) {
  const auto tree = parse_document(json, document, limits.max_bytes);
  if (!tree) return tree.error();
  return BatchReader(document, limits).read(*tree);
}

}  // namespace meshgauge::api
