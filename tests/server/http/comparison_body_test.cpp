#include "server/http/comparison_body.h"

#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <memory>
#include <string>

#include <doctest/doctest.h>

using namespace meshgauge;
using namespace meshgauge::server;

namespace {

struct BodySent {
  BodySent(const std::string& type, const std::string& bytes) {
    REQUIRE(::socketpair(AF_UNIX, SOCK_STREAM, 0, ends.data()) == 0);
    REQUIRE(::send(ends[1], bytes.data(), bytes.size(), 0) == static_cast<ssize_t>(bytes.size()));
    Head head;
    head.method = "POST";
    head.headers = {{"content-type", type}};
    head.content_length = bytes.size();
    Connection connection(ends[0]);
    Body raw(connection, head, 1 << 20);
    Exchange exchange("id", head, raw);
    ComparisonBody::receive(body, exchange, [this](const Body::Refusal& refusal) {
      ++calls;
      if (refusal) detail = refusal->detail;
    });
    if (raw.reading()) CHECK(raw.go_on() == Transport::Step::done);
    CHECK(calls == 1);
  }
  ~BodySent() {
    for (const int end : ends) ::close(end);
  }

  std::array<int, 2> ends{-1, -1};
  const Settings settings;
  ByteBudget budget{1 << 20};
  const std::shared_ptr<ComparisonBody> body = std::make_shared<ComparisonBody>(settings, budget);
  int calls = 0;
  std::string detail;  // of the refusal; empty: there is none
};

std::string field_of(const std::string& name, const std::string& bytes) {
  return "--z\r\nContent-Disposition: form-data; name=\"" + name + "\"; filename=\"x.obj\"\r\n\r\n" + bytes + "\r\n";
}

constexpr const char* kForm = "multipart/form-data; boundary=z";

}  // namespace

TEST_CASE("comparison body: a form has both meshes, and the default options") {
  const BodySent sent(kForm, field_of("a", "v 0 0 0\n") + field_of("b", "v 0 0 1\n") + "--z--\r\n");
  CHECK(sent.detail.empty());
  REQUIRE(sent.body->is_form());
  const Form& form = sent.body->form();
  CHECK(form.a.upload->text() == "v 0 0 0\n");
  CHECK(form.b.upload->text() == "v 0 0 1\n");
  CHECK(form.options == "{}");
}

TEST_CASE("comparison body: a form that lacks its end or a mesh is refused") {
  CHECK(BodySent(kForm, field_of("a", "x") + field_of("b", "y")).detail.find("closing boundary") != std::string::npos);
  CHECK(BodySent(kForm, field_of("a", "x") + "--z--\r\n").detail.starts_with("the part 'b' is missing"));
}

TEST_CASE("comparison body: JSON is kept as it is, within its limit") {
  const BodySent sent("Application/JSON; charset=utf-8", R"({"a": "1"})");
  CHECK(sent.detail.empty());
  CHECK_FALSE(sent.body->is_form());
  CHECK(sent.body->text() == R"({"a": "1"})");
  const BodySent large("application/json", std::string(100'000, ' '));
  CHECK(large.detail.starts_with("the body is larger than the limit of "));
}

TEST_CASE("comparison body: another type is refused before anything is read") {
  const BodySent sent("text/plain", "x");
  CHECK(sent.detail.find("curl -F a=@part.stl") != std::string::npos);
  CHECK_FALSE(sent.body->is_form());
}
