#include "server/jobs/parts.h"

#include <algorithm>
#include <charconv>

#include "api/part_document.h"
#include "api/problem.h"
#include "server/log.h"

namespace meshgauge::server {
namespace {

constexpr char kMark = '.';  // between the id of the whole, which has none, and the part's index

std::string problem_of(const store::Job& part) {
  if (!part.problem.empty()) return part.problem;
  return api::to_json(api::Problem{api::ProblemKind::internal, "a part was given up: " + part.last_error, {}});
}

}  // namespace

store::JobKey part_key(const store::JobKey& whole, unsigned index) {
  return {whole.owner, whole.id + kMark + std::to_string(index)};
}

std::optional<PartKey> part_of(const store::JobKey& key) {
  const std::size_t mark = key.id.rfind(kMark);
  if (mark == std::string::npos) return std::nullopt;
  PartKey part{{key.owner, key.id.substr(0, mark)}, 0};
  const char* const end = key.id.data() + key.id.size();
  const auto [rest, error] = std::from_chars(key.id.data() + mark + 1, end, part.index);
  if (error != std::errc() || rest != end) return std::nullopt;
  return part;
}

std::vector<store::NewJob> parts_of(const store::NewJob& whole, unsigned count) {
  std::vector<store::NewJob> parts(count, whole);
  for (unsigned i = 0; i < count; ++i) {
    parts[i].key = part_key(whole.key, i);
    parts[i].idempotency_key.clear();
    parts[i].fingerprint.clear();
    parts[i].batch.clear();
  }
  return parts;
}

Together put_together(std::span<const store::Job> parts, const api::Request& request) {
  const auto failed = std::find_if(parts.begin(), parts.end(),
                                   [](const store::Job& part) { return part.state == store::JobState::failed; });
  if (failed != parts.end()) return {std::nullopt, problem_of(*failed)};
  std::vector<std::string> documents;
  for (const store::Job& part : parts) documents.push_back(part.document);
  auto merged = api::merge_parts(documents, request);
  if (merged) return {std::move(*merged), ""};
  if (!parts.empty()) log_event("parts", "measured in one piece instead: " + merged.error().message);
  return {};
}

}  // namespace meshgauge::server
