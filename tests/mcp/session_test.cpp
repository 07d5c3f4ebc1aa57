// A session whose calls run at once, in receive(). tests/mcp/test_session.py has one over a process.
#include "cli/mcp/session.h"

#include <openssl/evp.h>

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <doctest/doctest.h>

#include "folder.h"

using namespace meshgauge;
using namespace meshgauge::mcp;
using meshgauge::api::test::Folder;

namespace {

class InOneThread {
 public:
  InOneThread()
      : session_({within(folder), 2}, 0,
                 [this](const std::string& line, Session::Line) { sent_.push_back(Json::parse(line)); }) {}

  // What is answered to a request.
  Json ask(const std::string& method, const std::string& params = "{}") {
    session_.receive(R"({"jsonrpc":"2.0","id":1,"method":")" + method + R"(","params":)" + params + "}");
    const Json answer = sent_.back();
    CHECK(answer.at("id") == 1);
    return answer;
  }
  Json call(const std::string& tool, const std::string& arguments) {
    return ask("tools/call", R"({"name":")" + tool + R"(","arguments":)" + arguments + "}").at("result");
  }
  std::vector<Json>& sent() { return sent_; }
  Session& session() { return session_; }

  const Folder folder;

 private:
  static std::shared_ptr<const api::Confines> within(const Folder& root) {
    return std::make_shared<const api::Confines>(api::Confines{api::Roots::open({root.path().string()}).value()});
  }

  std::vector<Json> sent_;
  Session session_;
};

std::string text_in(const Json& result) { return result.at("content").at(0).at("text").get<std::string>(); }

}  // namespace

TEST_CASE("session: a call answers in one line, with text, structured content and a picture") {
  InOneThread client;
  client.folder.write("a.off", "OFF\n3 1 0\n0 0 3\n1 0 3\n0 1 3\n3 0 1 2\n");
  client.folder.write("b.off", api::test::small_mesh());
  const Json result = client.call(
      "compare_meshes", R"({"a":{"path":"a.off"},"b":{"path":"b.off"},"options":{"max_distance":1,"threads":1}})");
  CHECK(result.at("isError") == false);
  CHECK(result.at("structuredContent").at("verdict") == "fail");
  CHECK(result.at("structuredContent").at("criteria").at(0).at("verdict") == "fail");
  CHECK(Json::parse(result.at("content").at(1).at("text").get<std::string>()) == result.at("structuredContent"));
  CHECK(result.at("content").at(2).at("mimeType") == "image/png");
  CHECK(result.at("content").at(2).at("data").get<std::string>().starts_with("iVBORw0KGgo"));
  CHECK(text_in(result).starts_with("fail: the distance is at least "));
}

TEST_CASE("session: base64 is decoded as it was encoded") {
  InOneThread client;
  const std::string mesh = api::test::small_mesh();
  for (std::size_t more = 0; more < 4; ++more) {
    const std::string bytes = mesh + std::string(more, '\n');
    std::string text(4 * ((bytes.size() + 2) / 3) + 1, '\0');
    const int length =
        EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()),
                        reinterpret_cast<const unsigned char*>(bytes.data()), static_cast<int>(bytes.size()));
    text.resize(static_cast<std::size_t>(length));
    const Json result = client.call("inspect_mesh", R"({"mesh":{"base64":")" + text + "\"}}");
    CHECK(result.at("structuredContent").at("bytes") == bytes.size());
    CHECK(result.at("structuredContent").at("triangles") == 1);
  }
}

TEST_CASE("session: mistakes of arguments are the answer of the tool") {
  InOneThread client;
  const Json result = client.call("compare_meshes", R"({"a":{},"options":{"max_distance":-1}})");
  CHECK(result.at("isError") == true);
  CHECK_FALSE(result.contains("structuredContent"));
  CHECK(
      text_in(result).starts_with("/a must have a path or base64, one of both\n/b is missing: name a mesh\n"
                                  "/options/max_distance "));
}

TEST_CASE("session: progress is told under the client's token") {
  InOneThread client;
  client.folder.write("a.off", api::test::small_mesh(2));
  client.folder.write("b.off", api::test::small_mesh());
  client.folder.write("gates.yaml",
                      "version: 1\ngates: [{name: x, candidate: a.off, baseline: b.off, max_distance: 5}]\n");
  client.ask("tools/call", R"({"name":"check_gates","_meta":{"progressToken":"t"}})");
  REQUIRE(client.sent().size() == 2);
  CHECK(client.sent()[0].at("method") == "notifications/progress");
  const Json wanted{{"progressToken", "t"}, {"progress", 1.0}, {"total", 1.0}, {"message", "x: pass"}};
  CHECK(client.sent()[0].at("params") == wanted);
  CHECK(client.sent()[1].at("result").at("structuredContent").at("verdict") == "pass");
}

TEST_CASE("session: every option of the table that Python has is in the schema, and no other") {
  InOneThread client;
  const Json tools = client.ask("tools/list").at("result").at("tools");
  const Json& options = tools.at(0).at("inputSchema").at("properties").at("options").at("properties");
  const auto keys = api::options_of(api::kPython);
  CHECK(options.size() == keys.size());
  for (const std::string_view key : keys) CHECK(options.contains(std::string(key)));
  for (const auto& [key, schema] : options.items()) CHECK(schema.at("description").get<std::string>().size() > 10);
}

TEST_CASE("session: a message that was too long is refused under its id") {
  InOneThread client;
  client.session().refuse_long("\"x\"");
  CHECK(client.sent().at(0).at("id") == "x");
  CHECK(client.sent().at(0).at("error").at("code") == kInvalidMessage);
}
