#include "server/sandbox/protocol.h"

#include <string>

#include <doctest/doctest.h>

using namespace meshgauge;
using namespace meshgauge::server::sandbox;

namespace {

api::ReadNotes notes() {
  api::ReadNotes notes;
  notes.gzip = true;
  notes.cloud = true;
  notes.polygons = {5, 4, 3, 2, 0.5};
  notes.helper_objects = 17;
  notes.remarks = {"one", "two"};
  notes.skipped_primitives = 7;
  notes.welded_vertices = 11;
  notes.unused_objects = 13;
  notes.unit = api::LengthUnit::inch;
  notes.filename_says = api::Format::obj;
  return notes;
}

const Reply kMesh = Arrays{api::Format::ply, notes(), 1'000'000'000'000, 12, 99};
const Reply kError = Error{ErrorCode::non_finite_vertex, "line 3 of 'a': no", "a", "line 3"};

}  // namespace

TEST_CASE("protocol: messages round-trip") {
  const auto mesh = decode_reply(encode(kMesh));
  REQUIRE((mesh && *mesh));
  CHECK((*mesh)->format == api::Format::ply);
  CHECK((*mesh)->notes.gzip);
  CHECK((*mesh)->notes.cloud);
  CHECK((*mesh)->notes.polygons == api::PolygonNotes{5, 4, 3, 2, 0.5});
  CHECK((*mesh)->notes.helper_objects == 17);
  CHECK((*mesh)->notes.remarks == std::vector<std::string>{"one", "two"});
  CHECK((*mesh)->notes.skipped_primitives == 7);
  CHECK((*mesh)->notes.welded_vertices == 11);
  CHECK((*mesh)->notes.unused_objects == 13);
  CHECK((*mesh)->notes.unit == api::LengthUnit::inch);
  CHECK((*mesh)->notes.filename_says == api::Format::obj);
  CHECK(!(*mesh)->notes.media_type_says);
  CHECK((*mesh)->vertices == 1'000'000'000'000);
  CHECK((*mesh)->triangles == 12);
  CHECK((*mesh)->group_bytes == 99);

  const auto error = decode_reply(encode(kError));
  REQUIRE((error && !*error));
  CHECK(error->error().code == ErrorCode::non_finite_vertex);
  CHECK(error->error().message == "line 3 of 'a': no");
  CHECK(error->error().part == "a");
  CHECK(error->error().where == "line 3");

  const auto request = decode_request(encode(Request{9, {1, 2, 3}, "a", "x.obj", "model/obj"}));
  REQUIRE(request);
  CHECK(request->input_bytes == 9);
  CHECK(request->limits.max_vertices == 1);
  CHECK(request->limits.max_triangles == 2);
  CHECK(request->limits.max_expanded_bytes == 3);
  CHECK(request->part == "a");
  CHECK(request->filename == "x.obj");
  CHECK(request->media_type == "model/obj");

  const auto bounds = decode_bounds(encode(Bounds{1, 2, 4, false}));
  REQUIRE(bounds);
  CHECK(bounds->memory_bytes == 1);
  CHECK(bounds->input_bytes == 2);
  CHECK(bounds->cpu_seconds == 4);
  CHECK(!bounds->filter);

  const auto trial = decode_trial(encode(Trial{"no limits", "", "too large"}));
  REQUIRE(trial);
  CHECK(trial->limits == "no limits");
  CHECK(trial->filter.empty());
  CHECK(trial->small == "too large");
}

TEST_CASE("protocol: groups round-trip, and no other bytes are some") {
  const api::Groups groups{{{"a", {{0, 3}, {5, 12}}}, {"b", {{2, 4}}}}, false};
  const std::string whole = encode(groups);
  CHECK(decode_groups(whole, 12) == groups);
  CHECK(!decode_groups(whole, 11));
  CHECK(decode_groups(encode(api::Groups{{}, true}), 1)->too_many);
  for (std::size_t length = 0; length < whole.size(); ++length) CHECK(!decode_groups(whole.substr(0, length), 12));
  CHECK(!decode_groups(whole + '\0', 12));
  for (std::size_t i = 0; i < whole.size(); ++i) {
    for (int value = 0; value < 256; ++value) {
      std::string changed = whole;
      changed[i] = static_cast<char>(value);
      const auto decoded = decode_groups(changed, 12);
      if (decoded) CHECK(is_valid(*decoded, 12));
    }
  }
}

TEST_CASE("protocol: a reader cannot send the server's own error codes") {
  for (const ErrorCode code : {ErrorCode::unsupported_format, ErrorCode::too_large, ErrorCode::internal}) {
    CHECK(decode_reply(encode(Reply(Error{code, "x", "", ""}))));
  }
  for (const ErrorCode code : {ErrorCode::invalid_request, ErrorCode::out_of_time}) {
    CHECK(!decode_reply(encode(Reply(Error{code, "x", "", ""}))));
  }
}

TEST_CASE("protocol: a truncated or longer message is rejected") {
  for (const Reply& reply : {kMesh, kError}) {
    const std::string whole = encode(reply);
    for (std::size_t length = 0; length < whole.size(); ++length) CHECK(!decode_reply(whole.substr(0, length)));
    CHECK(!decode_reply(whole + '\0'));
  }
  const std::string request = encode(Request{9, {1, 2, 3}, "a", "x.obj", ""});
  for (std::size_t length = 0; length < request.size(); ++length) CHECK(!decode_request(request.substr(0, length)));
}

TEST_CASE("protocol: no byte of a reply puts an enumeration, a flag or a text out of range") {
  for (const Reply& reply : {kMesh, kError}) {
    const std::string whole = encode(reply);
    for (std::size_t i = 0; i < whole.size(); ++i) {
      for (int value = 0; value < 256; ++value) {
        std::string changed = whole;
        changed[i] = static_cast<char>(value);
        const auto decoded = decode_reply(changed);
        if (!decoded) continue;
        if (*decoded) {
          CHECK((*decoded)->format <= api::Format::xyz);
          CHECK((*decoded)->notes.unit.value_or(api::LengthUnit::micron) <= api::LengthUnit::foot);
          CHECK((*decoded)->notes.polygons.largest_deviation >= 0);
          for (const std::string& remark : (*decoded)->notes.remarks) CHECK(remark.size() <= api::kMaxRemarkBytes);
          CHECK((*decoded)->notes.filename_says.value_or(api::Format::obj) <= api::Format::xyz);
          CHECK((*decoded)->notes.media_type_says.value_or(api::Format::obj) <= api::Format::xyz);
        } else {
          CHECK(decoded->error().code <= ErrorCode::internal);
          CHECK(decoded->error().message.size() <= whole.size());
        }
      }
    }
  }
}

TEST_CASE("protocol: texts that are too long are cut, a hint at its beginning") {
  const auto request = decode_request(encode(Request{0, {}, "a", std::string(9000, 'x') + ".obj", ""}));
  REQUIRE(request);
  CHECK(request->filename.size() == 1024);
  CHECK(request->filename.ends_with("x.obj"));
  const auto error = decode_reply(encode(Reply(Error{ErrorCode::internal, std::string(9000, 'x'), "", ""})));
  REQUIRE(error);
  CHECK(error->error().message.size() == 4096);
}
