#include "server/http/comparison_form.h"

#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "api/base/digest.h"
#include "api/formats/format.h"
#include "api/formats/gltf/gltf_bundle.h"

using namespace meshgauge;
using namespace meshgauge::server;

namespace {

struct Sent {
  std::string name;
  std::string filename;
  std::string content;
};

const std::string kScene = R"( {"asset": {"version": "2.0"}, "buffers": [{"byteLength": 3, "uri": "x.bin"}]})";

Settings small() {
  Settings settings;
  settings.max_part_bytes = 2'000;
  return settings;
}

std::string uploaded(const Upload& upload) {
  return {reinterpret_cast<const char*>(upload.bytes().data()), upload.bytes().size()};
}

// Returns the refusal of the parts; "": the form was received.
std::string receive(const std::vector<Sent>& parts, Form& form, const Settings& settings, ByteBudget& budget) {
  FormReceiver receiver(form, settings, budget);
  for (const Sent& part : parts) {
    if (const auto refusal = receiver.begin({part.name, part.filename, ""})) return refusal->detail;
    for (const char c : part.content) {
      if (const auto refusal = receiver.data({&c, 1})) return refusal->detail;
    }
    if (const auto refusal = receiver.end()) return refusal->detail;
  }
  const auto refusal = receiver.complete();
  return refusal ? refusal->detail : "";
}

std::string refusal(const std::vector<Sent>& parts, std::uint64_t budget_bytes = 1 << 20) {
  const Settings settings = small();
  ByteBudget budget(budget_bytes);
  Form form;
  return receive(parts, form, settings, budget);
}

std::string refused_name(const std::string& name) {
  return refusal({{"a", "s.gltf", kScene}, {"a.files", name, "abc"}, {"b", "s.gltf", kScene}});
}

bool contains(const std::string& text, const std::string& piece) { return text.find(piece) != std::string::npos; }

}  // namespace

TEST_CASE("form: a mesh and its files become one archive, in any order") {
  const Settings settings = small();
  ByteBudget budget(1 << 20);
  std::vector<std::string> archives;
  const Sent a{"a", "any name", kScene}, b{"b", "b.gltf", kScene}, x{"a.files", "x.bin", "abc"},
      y{"a.files", "./sub/y.bin", "de"};
  for (const auto& parts : {std::vector{a, x, y, b}, std::vector{y, x, b, a}}) {
    Form form;
    REQUIRE(receive(parts, form, settings, budget) == "");
    CHECK(uploaded(*form.b.upload) == kScene);
    CHECK(form.a.head.filename == "any name");
    archives.push_back(uploaded(*form.a.upload));
    CHECK(budget.used() == archives.back().size() + kScene.size());
  }
  CHECK(budget.used() == 0);
  CHECK(archives[0] == archives[1]);
  std::string expected;
  api::BundleWriter writer([&](std::string_view piece) { return expected += piece, true; });
  const auto add = [&](const char* path, std::string_view text) { writer.add(path, std::as_bytes(std::span(text))); };
  add("scene.gltf", kScene);
  add("sub/y.bin", "de");
  add("x.bin", "abc");
  writer.finish();
  CHECK(archives[0] == expected);
  CHECK(api::detect_format(std::as_bytes(std::span(expected)), {"a", "", ""}) == api::Format::gltf);
}

TEST_CASE("form: the archive is that of the page, byte for byte") {
  const Settings settings = small();
  ByteBudget budget(1 << 20);
  Form form;
  const std::string scene = R"({"buffers":[{"uri":"x.bin"}]})";
  const std::vector<Sent> parts{
      {"a", "any.gltf", scene}, {"a.files", "x.bin", "abc"}, {"a.files", "sub/\xC3\xA4.bin", "de"}, {"b", "", scene}};
  REQUIRE(receive(parts, form, settings, budget) == "");
  // tests/web/unit/pairing.test.ts has the same.
  CHECK(api::sha256_hex(form.a.upload->bytes()) == "98ead8770aaa7e0f62eed5be5e86f7fce4602a8b818a4319bc7a85036f5eef31");
}

TEST_CASE("form: names that no .gltf may use are refused") {
  for (const char* name : {"../x.bin", "a/../../x.bin", ".."}) CHECK(contains(refused_name(name), "has '..'"));
  CHECK(contains(refused_name("/etc/passwd"), "the file name '/etc/passwd' of a part 'a.files' is absolute"));
  CHECK(contains(refused_name("C:\\x.bin"), "has a scheme"));
  CHECK(contains(refused_name("file:///x.bin"), "has a scheme"));
  CHECK(contains(refused_name("a\\x.bin"), "has a backslash"));
  CHECK(contains(refused_name("x\n.bin"), "'x?.bin' of a part 'a.files' has a control character"));
  CHECK(contains(refused_name(""), "is empty"));
  CHECK(contains(refused_name("folder/"), "names a folder"));
  CHECK(contains(refused_name("t.GLTF"), "is that of a .gltf"));
  CHECK(refused_name("%2e%2e/x.bin").empty());  // the name of a file, which no URI can ask for but as %252e
}

TEST_CASE("form: limits of the files") {
  const Sent a{"a", "a.gltf", kScene}, b{"b", "b.gltf", kScene};
  CHECK(contains(refusal({a, b, {"b.files", "x.bin", ""}, {"b.files", "./x.bin", ""}}),
                 "'./x.bin' of a part 'b.files' was sent twice"));
  CHECK(contains(refusal({a, b, {"b.files", "A.bin", ""}, {"b.files", "a.bin", ""}}),
                 "'a.bin' of a part 'b.files' differs from 'A.bin' by letter case alone"));
  CHECK(contains(refusal({a, b, {"b.files", "./_rels/.RELS", ""}}), "is the name of a part that every 3MF has"));
  CHECK(contains(refusal({{"a", "a.obj", "v 0 0 0"}, {"a.files", "x.bin", "abc"}, b}),
                 "the part 'a' is not a .gltf document"));
  CHECK(refusal({{"a.files", "x.bin", "abc"}, b}) == "the part 'a' is missing; the form holds 'a.files', 'b'");
  CHECK(refusal({a, {"a.files", "x.bin", std::string(2'000, 'x')}, b}) ==
        "the part 'a.files' and the files beside it are together larger than the limit of 2000 bytes");
  CHECK(refusal({a, {"a.files", "x.bin", std::string(1'800, 'x')}, b}) ==
        "the part 'a' with its files is larger than the limit of 2000 bytes");
  CHECK(contains(refusal({a, {"a.files", "x.bin", std::string(1'000, 'x')}, b}, 1'500), "all uploads together"));
  std::vector<Sent> many{a, b};
  for (std::size_t i = 0; i <= api::kMostBundleFiles; ++i) many.push_back({"a.files", "x" + std::to_string(i), ""});
  CHECK(refusal(many) == "too many parts 'a.files' (limit 64)");
}

TEST_CASE("form: a part of another name is refused with the names of all parts") {
  const Sent a{"a", "a.gltf", kScene}, b{"b", "b.gltf", kScene};
  const std::string known = "; known: a and b, the meshes, options, and a.files and b.files, what a .gltf names";
  CHECK(refusal({a, b, {"c.files", "x", ""}}) == "unknown part 'c.files'; the form holds 'a', 'b', 'c.files'" + known);
  CHECK(refusal({{"file1", "a.stl", "x"}, {"file2", "b.stl", "y"}}) ==
        "unknown part 'file1'; the form holds 'file1', 'file2'" + known);
  CHECK(refusal({{"A", "a.stl", "x"}, a, a}) == "unknown part 'A'; the form holds 'A', 'a', 'a'" + known);
  std::vector<Sent> many(20, Sent{"mesh[]", "m", std::string(100, 'x')});
  CHECK(refusal(many, 1) == "unknown part 'mesh[]'; the form holds " + [] {
    std::string names = "'mesh[]'";
    for (int i = 0; i < 7; ++i) names += ", 'mesh[]'";
    return names;
  }() + " and 12 more" + known);
  CHECK(refusal(std::vector<Sent>{}) == "the part 'a' is missing; the form holds no part");
}

TEST_CASE("form: what follows an unknown part is discarded, up to 16 MiB") {
  const Settings settings = small();
  ByteBudget budget(1);
  Form form;
  FormReceiver receiver(form, settings, budget);
  CHECK(!receiver.begin({"mesh", "m.stl", ""}));
  const std::string piece(1 << 20, 'x');
  for (int i = 0; i < 16; ++i) CHECK(!receiver.data(piece));
  CHECK(receiver.data("x")->detail.starts_with("unknown part 'mesh'; the form holds 'mesh'; known"));
  CHECK(budget.used() == 0);
}

TEST_CASE("form: the name of a file in place of the file") {
  const Sent b{"b", "b.gltf", kScene};
  const auto said = [&](const std::string& text) { return refusal({{"a", "", text}, b}); };
  CHECK(said("part.stl") == "field 'a' holds the text 'part.stl', not a file: write -F a=@part.stl");
  CHECK(said("my part.STL\r\n") == "field 'a' holds the text 'my part.STL', not a file: write -F \"a=@my part.STL\"");
  CHECK(said("@part.obj.gz") == "field 'a' holds the text '@part.obj.gz', not a file: write -F a=@part.obj.gz");
  CHECK(said("C:\\parts\\part.step") ==
        "field 'a' holds the text 'C:\\parts\\part.step', not a file: write -F a=@C:\\parts\\part.step");
  for (const char* name : {"/tmp/part", "./part", "../part", "~/part", "build/part.3mf", "bracket.step"})
    CHECK(contains(said(name), "not a file: write -F a=@"));
  CHECK(refusal({{"a", "a.gltf", kScene}, {"b", "", "part.stl"}}).starts_with("field 'b' holds the text 'part.stl'"));
  CHECK(refusal({{"options", "", "options.json"}}) ==
        "field 'options' holds the text 'options.json', not a file: write -F options=@options.json");
  // What may be a mesh, or is the content of a file.
  for (const char* text : {"", "x", "1.5", "0 0 1.5", "1 2 3.e5", "v 0 0 0\nf part.stl", "part", "a\nb.stl"})
    CHECK(said(text).empty());
  CHECK(said(kScene).empty());
  CHECK(refusal({{"a", "a.stl", "part.stl"}, b}).empty());
}
