#include "cli/mcp/message.h"

#include <algorithm>
#include <string>
#include <string_view>
#include <variant>

#include <doctest/doctest.h>

using namespace meshgauge::mcp;

namespace {

// "code id" of a refusal, "id method" of a request, "nothing".
std::string as_read(std::string_view line) {
  const Received received = read_message(line);
  if (const auto* refusal = std::get_if<Refusal>(&received)) {
    CHECK_FALSE(refusal->message.empty());
    return std::to_string(refusal->code) + " " + refusal->id;
  }
  const auto* request = std::get_if<Request>(&received);
  return request ? request->id + " " + request->method + " " + request->params.dump() : "nothing";
}

std::string scanned(std::string_view text, std::size_t piece) {
  IdScanner scanner;
  for (; !text.empty(); text.remove_prefix(std::min(piece, text.size()))) scanner.take(text.substr(0, piece));
  return scanner.id();
}

}  // namespace

TEST_CASE("message: requests and notifications") {
  CHECK(as_read(R"({"jsonrpc":"2.0","id":1,"method":"ping"})") == "1 ping {}");
  CHECK(as_read(R"({"jsonrpc":"2.0","id":"a\"b","method":"m","params":{"x":[1]}})") == R"("a\"b" m {"x":[1]})");
  CHECK(as_read(R"(  {"method":"n","jsonrpc":"2.0"} )"
                "\r") == " n {}");
  CHECK(as_read(R"({"jsonrpc":"2.0","id":1,"result":{}})") == "nothing");
  CHECK(as_read(R"({"jsonrpc":"2.0","id":1,"error":{}})") == "nothing");
  CHECK(as_read(R"({"jsonrpc":"2.0","id":null,"error":{}})") == "nothing");
  CHECK(as_read(R"({"jsonrpc":"2.0","method":"n","params":5})") == "nothing");
}

TEST_CASE("message: what is refused, by which code and under which id") {
  CHECK(as_read("") == "-32700 null");
  CHECK(as_read("{") == "-32700 null");
  CHECK(as_read(std::string_view("{}\0", 3)) == "-32700 null");
  CHECK(as_read("[]") == "-32600 null");
  CHECK(as_read(R"([{"jsonrpc":"2.0","id":1,"method":"ping"}])") == "-32600 null");
  CHECK(as_read("7") == "-32600 null");
  CHECK(as_read("{}") == "-32600 null");
  CHECK(as_read(R"({"jsonrpc":"2.0","id":true,"method":"ping"})") == "-32600 null");
  CHECK(as_read(R"({"jsonrpc":2.0,"id":1,"method":"ping"})") == "-32600 1");
  CHECK(as_read(R"({"jsonrpc":"2.0","id":1})") == "-32600 1");
  CHECK(as_read(R"({"jsonrpc":"2.0","id":1,"method":null})") == "-32600 1");
  CHECK(as_read(R"({"jsonrpc":"2.0","id":1,"method":"m","params":null})") == "-32602 1");
  CHECK(as_read(R"({"jsonrpc":"2.0","id":1,"id":2,"method":"m"})") == "-32600 2");
  const std::string long_id(kMostIdBytes + 1, 'x');
  CHECK(as_read(R"({"jsonrpc":"2.0","id":")" + long_id + R"(","method":"m"})") == "-32600 null");
}

TEST_CASE("message: one of very many values is refused, however few bytes each has") {
  std::string values;
  for (int i = 0; i < 100'000; ++i) values += "{},";
  const auto refusal =
      std::get<Refusal>(read_message(R"({"jsonrpc":"2.0","id":1,"method":"ping","params":{"x":[)" + values + "{}]}}"));
  CHECK(refusal.code == kInvalidMessage);
  CHECK(refusal.id == "1");
  CHECK(refusal.message == "more than 100000 values");
}

TEST_CASE("message: an error repeats little of what was sent") {
  const auto refusal = std::get<Refusal>(read_message("{\"" + std::string(1'000'000, 'x')));
  CHECK(refusal.message.size() < 400);
}

TEST_CASE("message: lines that are sent") {
  CHECK(answer_line("\"x\"", {{"a", 1}}) == R"({"jsonrpc":"2.0","id":"x","result":{"a":1}})");
  CHECK(refusal_line({kInvalidMessage, "no\n", "3"}) ==
        R"({"jsonrpc":"2.0","id":3,"error":{"code":-32600,"message":"no\n"}})");
  CHECK(notification_line("n", {{"a", "\xff"}}) ==
        "{\"jsonrpc\":\"2.0\",\"method\":\"n\",\"params\":{\"a\":\"\xEF\xBF\xBD\"}}");
}

TEST_CASE("message: the id of a message that is not kept, in pieces of any size") {
  const std::string_view text =
      R"({"jsonrpc" : "2.0", "params":{"id":1,"x":["\"id\":2,",{"id":3}]}, "id" : "a\"}" , "method":"m"})";
  for (std::size_t piece = 1; piece <= text.size(); ++piece) CHECK(scanned(text, piece) == R"("a\"}")");
  CHECK(scanned(R"({"id":12})", 3) == "12");
  CHECK(scanned(R"({"id":-12,"x":1)", 3) == "-12");
  CHECK(scanned(R"({"id":12)", 3) == "null");  // it might go on
  CHECK(scanned(R"({"id":{}})", 3) == "null");
  CHECK(scanned(R"({"id":[1]})", 3) == "null");
  CHECK(scanned(R"({"id":1.5})", 3) == "null");
  CHECK(scanned(R"({"id":"x)", 3) == "null");
  CHECK(scanned(R"({"ID":1,"i":2})", 3) == "null");
  CHECK(scanned(R"({"id":")" + std::string(kMostIdBytes + 1, 'x') + "\"}", 100) == "null");
  CHECK(scanned(std::string(100'000, '['), 1000) == "null");
  CHECK(scanned("]]]]}}},,,", 3) == "null");
}
