// Files of a batch, from their arrival until the batch is stored.
#include "server/handlers/batch_receiver.h"

#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <string>
#include <thread>

#include <doctest/doctest.h>

#include "server/main/checked.h"
#include "tests/server/store/implementations.h"

using namespace meshgauge;
using namespace meshgauge::server;
using store::got;
using store::key_of;
using namespace std::chrono_literals;

namespace {

const std::string kManifest = R"({"comparisons": [{"a": {"part": "x"}, "b": {"part": "y"}}]})";

// Receives a form of the manifest and two files.
struct ReceiverBench {
  ReceiverBench() {
    REQUIRE(::socketpair(AF_UNIX, SOCK_STREAM, 0, ends.data()) == 0);
    std::string form;
    for (const auto& [name, bytes] : {std::pair<std::string, std::string>("manifest", kManifest), {"x", x}, {"y", y}}) {
      form += "--z\r\nContent-Disposition: form-data; name=\"" + name + "\"\r\n\r\n" + bytes + "\r\n";
    }
    form += "--z--\r\n";
    head.method = "POST";
    head.headers = {{"content-type", "multipart/form-data; boundary=z"}};
    head.content_length = form.size();
    REQUIRE(::send(ends[1], form.data(), form.size(), 0) == static_cast<ssize_t>(form.size()));
    Connection connection(ends[0]);
    Body body(connection, head, 10000);
    Exchange exchange("id", head, body);
    bool arrived = false;
    BatchReceiver::receive(kept, exchange, [&](const Body::Refusal& refusal) { arrived = !refusal; });
    CHECK(body.go_on() == Transport::Step::done);
    CHECK(arrived);
  }
  ~ReceiverBench() {
    for (const int end : ends) ::close(end);
  }

  const std::string x = "v 0 0 0\n";
  const std::string y = "v 0 0 1\n";
  std::array<int, 2> ends{-1, -1};
  Head head;
  store::EmbeddedForTests embedded;
  store::BlobStore& blobs = embedded.blobs();
  MeshCache cache{1 << 20};
  const Stores stores{embedded.jobs(), embedded.meshes(), blobs, embedded.signals(), cache};
  const Settings settings = checked(Settings()).value();
  Access access{""};
  ByteBudget budget{1 << 20};
  const std::shared_ptr<BatchReceiver> kept =
      std::make_shared<BatchReceiver>("ann", true, settings, stores, access, budget);
  BatchReceiver& receiver = *kept;
};

}  // namespace

TEST_CASE("batches: files that arrived long ago are renewed before the batch is stored") {
  ReceiverBench bench;
  std::this_thread::sleep_for(1100ms);
  CHECK_FALSE(bench.receiver.renew(1s));
  CHECK(got(bench.blobs.remove_unused({}, 1s)) == 0);
  std::this_thread::sleep_for(1100ms);
  CHECK_FALSE(bench.receiver.renew(60s));  // what is not that old is left as it is
  CHECK(got(bench.blobs.remove_unused({}, 1s)) == 2);
}

TEST_CASE("batches: a file that was removed meanwhile is reported before the batch is stored") {
  ReceiverBench bench;
  got(bench.blobs.remove(key_of("ann", bench.y)));
  CHECK_FALSE(bench.receiver.renew(60s));
  const auto refusal = bench.receiver.renew(0s);
  REQUIRE(refusal.has_value());
  CHECK(refusal->kind == api::ProblemKind::storage_unavailable);
}
