// S3Blobs against a double that is overloaded, slow or stale, loses connections, cuts bodies and objects off, and has
// stored other bytes.
#include <atomic>
#include <thread>
#include <vector>

#include "../store_text.h"
#include "s3_for_tests.h"

using namespace meshgauge;
using namespace meshgauge::server::store;
using namespace std::chrono_literals;

namespace {

constexpr const char* kBlob = "/[0-9a-f]{2}/[0-9a-f]{64}$";

// S3 behind a cache, as in the service.
struct Stores {
  S3Double server;
  TestFolder folder;
  CachedBlobs blobs{std::make_unique<S3Blobs>(server.settings(), options_for_tests(), limits_for_tests()),
                    got(BlobCache::open(folder / "cache", 50'000'000))};

  Stores() { server.control("settings", {{"least_part", 1 << 20}}); }
  nlohmann::json state() const { return server.control("state", nullptr); }
  std::size_t uploads() const { return state()["uploads"].size(); }
  void fault(const nlohmann::json& fault) { server.control("faults", nlohmann::json::array({fault})); }
};

template <class T>
ErrorCode code_of(const Result<T>& result) {
  REQUIRE_FALSE(result.ok());
  return result.error().code;
}

}  // namespace

TEST_CASE("S3 in trouble: failures that may pass are tried again") {
  Stores stores;
  for (const char* what : {"slow_down", "reset", "done_but_lost"}) {
    CAPTURE(what);
    for (const std::string& text : {std::string("small"), long_text(5'000'000)}) {
      const BlobKey key = key_of(what, text);
      stores.server.fail("PUT", "", what, 2);
      CHECK(got(stores.blobs.put(key, bytes_of(text))) == BlobPut::created);
      stores.server.fail("GET", "", what, 2);
      CHECK(text_of(*got(stores.blobs.open(key))) == text);
      stores.server.fail("HEAD", "", what, 2);
      CHECK(got(stores.blobs.exists(key)));
      stores.server.fail("DELETE", "", what, 2);
      CHECK(got(stores.blobs.remove(key)));
      CHECK_FALSE(got(stores.blobs.exists(key)));
    }
  }
  CHECK(stores.uploads() == 0);
}

TEST_CASE("S3 in trouble: other failures are reported, and nothing is stored by half") {
  Stores stores;
  for (const std::string& text : {std::string("small"), long_text(5'000'000)}) {
    for (const char* what : {"slow_down", "reset"}) {
      CAPTURE(what);
      const BlobKey key = key_of("ann", text);
      stores.server.fail("PUT", text.size() < 10 ? kBlob : "partNumber=3", what, 100);
      CHECK(code_of(stores.blobs.put(key, bytes_of(text))) == ErrorCode::storage_unavailable);
      CHECK_FALSE(got(stores.blobs.exists(key)));
      CHECK(stores.uploads() == 0);
      stores.server.control("faults", nlohmann::json::array());
    }
  }
  stores.server.fail("HEAD", "", "slow_down", 100);
  CHECK(code_of(stores.blobs.exists(key_of("ann", "small"))) == ErrorCode::storage_unavailable);
  CHECK(stores.server.count("HEAD", "") >= 4);  // of attempts
}

TEST_CASE("S3 in trouble: an upload in parts survives a lost answer to its completion, and a late error") {
  Stores stores;
  const std::string text = long_text(5'000'000);
  for (const char* what : {"done_but_lost", "late_error", "reset", "slow_down"}) {
    CAPTURE(what);
    const BlobKey key = key_of(what, text);
    stores.server.fail("POST", "uploadId=", what);
    CHECK(got(stores.blobs.put(key, bytes_of(text))) == BlobPut::created);
    CHECK(text_of(*got(stores.blobs.open(key))) == text);
  }
  CHECK(stores.uploads() == 0);
  stores.server.fail("POST", "uploadId=", "late_error", 100);
  CHECK(code_of(stores.blobs.put(key_of("ann", text), bytes_of(text))) == ErrorCode::storage_unavailable);
  CHECK_FALSE(got(stores.blobs.exists(key_of("ann", text))));
  CHECK(stores.uploads() == 0);
}

TEST_CASE("S3 in trouble: a part that is refused ends the upload, when the others have ended") {
  Stores stores;
  const std::string text = long_text(30'000'000);
  const BlobKey key = key_of("ann", text);
  const nlohmann::json late{
      {"method", "PUT"}, {"match", "partNumber=[1245]&"}, {"times", 4}, {"what", "late"}, {"seconds", 0.3}};
  const nlohmann::json refused{{"method", "PUT"}, {"match", "partNumber=3&"}, {"times", 1}, {"what", "status"},
                               {"status", 403},   {"code", "AccessDenied"}};
  stores.server.control("faults", {late, refused});
  CHECK(code_of(stores.blobs.put(key, bytes_of(text))) == ErrorCode::storage_unavailable);
  CHECK(stores.uploads() == 0);
  CHECK(stores.state()["crossed"] == 0);
  CHECK(stores.server.count("PUT", "partNumber=") < 29);
  CHECK_FALSE(got(stores.blobs.exists(key)));
  CHECK(got(stores.blobs.put(key, bytes_of(text))) == BlobPut::created);
  CHECK(text_of(*got(stores.blobs.open(key))) == text);
}

TEST_CASE("S3 in trouble: an answer that is not S3's is not taken for one") {
  Stores stores;
  const BlobKey key = key_of("ann", "x");
  got(stores.blobs.put(key, bytes_of("x")));
  for (const int status : {400, 404, 405, 413}) {
    CAPTURE(status);
    const auto answer_once = [&](const char* method) {
      stores.fault({{"method", method},
                    {"match", kBlob},
                    {"times", 1},
                    {"what", "status"},
                    {"status", status},
                    {"body", "<html>default backend</html>"}});
    };
    answer_once("GET");
    CHECK(code_of(stores.blobs.open(key)) == ErrorCode::storage_unavailable);
    answer_once("PUT");
    CHECK(code_of(stores.blobs.renew(key)) == ErrorCode::storage_unavailable);
    answer_once("PUT");
    CHECK(code_of(stores.blobs.put(key_of("ann", "y"), bytes_of("y"))) == ErrorCode::storage_unavailable);
    answer_once("DELETE");
    CHECK(code_of(stores.blobs.remove(key)) == ErrorCode::storage_unavailable);
  }
  CHECK(text_of(*got(stores.blobs.open(key))) == "x");
}

TEST_CASE("S3 in trouble: an expired token and another region are not the request's fault") {
  Stores stores;
  const BlobKey key = key_of("ann", "x");
  got(stores.blobs.put(key, bytes_of("x")));
  for (const char* code : {"ExpiredToken", "InvalidToken", "AuthorizationHeaderMalformed"}) {
    CAPTURE(code);
    const auto refuse_once = [&](const char* method) {
      stores.fault(
          {{"method", method}, {"match", kBlob}, {"times", 1}, {"what", "status"}, {"status", 400}, {"code", code}});
    };
    refuse_once("GET");
    CHECK(code_of(stores.blobs.open(key)) == ErrorCode::storage_unavailable);
    refuse_once("HEAD");  // its answer has no code
    CHECK(code_of(stores.blobs.exists(key)) == ErrorCode::storage_unavailable);
  }
}

TEST_CASE("S3 in trouble: a server without room, and one that rejects the request") {
  Stores stores;
  const auto refuse = [&](int status, const char* code) {
    stores.server.control(
        "faults",
        {{{"method", "PUT"}, {"match", ""}, {"times", 1}, {"what", "status"}, {"status", status}, {"code", code}}});
    return code_of(stores.blobs.put(key_of("ann", "x"), bytes_of("x")));
  };
  CHECK(refuse(507, "XMinioStorageFull") == ErrorCode::storage_full);
  CHECK(refuse(403, "QuotaExceeded") == ErrorCode::storage_full);
  CHECK(refuse(403, "AccessDenied") == ErrorCode::storage_unavailable);
  CHECK(refuse(301, "PermanentRedirect") == ErrorCode::storage_unavailable);
  CHECK(refuse(400, "InvalidArgument") == ErrorCode::internal);
  CHECK(refuse(501, "NotImplemented") == ErrorCode::internal);
  CHECK(got(stores.blobs.put(key_of("ann", "x"), bytes_of("x"))) == BlobPut::created);
}

TEST_CASE("S3 in trouble: a body that is cut off is continued where it ended") {
  Stores stores;
  const std::string text = long_text(3'000'000);
  const BlobKey key = key_of("ann", text);
  got(stores.blobs.put(key, bytes_of(text)));
  stores.server.count("GET", "");
  stores.server.fail("GET", kBlob, "cut", 3);
  CHECK(text_of(*got(stores.blobs.open(key))) == text);
  const nlohmann::json log = stores.server.control("log", nullptr);
  REQUIRE(log.size() == 4);
  CHECK(log[0]["range"] == "");
  CHECK(log[1]["range"] == "bytes=1500000-");
  CHECK(log[2]["range"] == "bytes=2250000-");
  CHECK(log[3]["range"] == "bytes=2625000-");
}

TEST_CASE("S3 in trouble: bytes of another digest are fetched once more, then refused") {
  Stores stores;
  const BlobKey key = key_of("ann", "right");
  got(stores.blobs.put(key, bytes_of("right")));
  stores.server.fail("GET", kBlob, "wrong_bytes", 1);
  CHECK(text_of(*got(stores.blobs.open(key))) == "right");
  CHECK(stores.blobs.cache().counters().refused == 1);

  const BlobKey planted = key_of("ann", "planted");
  stores.server.control("plant",
                        {{{"key", stores.server.settings().prefix + "/" + blob_name(planted)}, {"text", "!"}}});
  CHECK(code_of(stores.blobs.open(planted)) == ErrorCode::internal);
  CHECK(stores.blobs.cache().counters().files == 1);
  CHECK(stores.blobs.cache().counters().refused == 3);
  got(stores.blobs.put(planted, bytes_of("planted")));
  CHECK(text_of(*got(stores.blobs.open(planted))) == "planted");
}

TEST_CASE("S3 in trouble: an answer of 200 that holds an error is none") {
  Stores stores;
  const BlobKey key = key_of("ann", "x");
  const BlobKey other = key_of("ann", "y");
  got(stores.blobs.put(key, bytes_of("x")));
  stores.server.fail("GET", kBlob, "late_error", 100);
  CHECK(code_of(stores.blobs.open(key)) == ErrorCode::internal);  // its bytes have another digest
  stores.server.fail("GET", kBlob, "late_error", 1);
  CHECK(text_of(*got(stores.blobs.open(key))) == "x");
  stores.server.fail("PUT", kBlob, "late_error", 100);
  CHECK(code_of(stores.blobs.put(other, bytes_of("y"))) == ErrorCode::storage_unavailable);
  CHECK_FALSE(got(stores.blobs.exists(other)));
  stores.server.fail("PUT", kBlob, "late_error", 1);
  CHECK(got(stores.blobs.put(other, bytes_of("y"))) == BlobPut::created);
  stores.server.fail("HEAD", kBlob, "late_error", 1);
  CHECK(code_of(stores.blobs.exists(key)) == ErrorCode::storage_unavailable);
  stores.server.fail("GET", "list-type", "late_error", 100);
  CHECK(code_of(stores.blobs.remove_unused({}, 0s)) == ErrorCode::storage_unavailable);
  stores.server.fail("DELETE", kBlob, "late_error", 100);
  CHECK(code_of(stores.blobs.remove(key)) == ErrorCode::storage_unavailable);
  CHECK(got(stores.blobs.exists(key)));
  stores.server.fail("DELETE", kBlob, "late_error", 1);
  CHECK(got(stores.blobs.remove(key)));
  CHECK_FALSE(got(stores.blobs.exists(key)));
}

TEST_CASE("S3 in trouble: objects that lost their end are refused, until they are stored again") {
  Stores stores;
  for (const std::string& text : {std::string("small"), long_text(5'000'000)}) {
    for (const std::size_t left : {std::size_t{0}, text.size() / 2, text.size() - 1}) {
      CAPTURE(left);
      const BlobKey key = key_of("ann " + std::to_string(left), text);
      CHECK(got(stores.blobs.put(key, bytes_of(text))) == BlobPut::created);
      const std::string object = stores.server.settings().prefix + "/" + blob_name(key);
      stores.server.control("truncate", {{"key", object}, {"bytes", left}});
      CHECK(code_of(stores.blobs.open(key)) == ErrorCode::internal);
      CHECK(got(stores.blobs.put(key, bytes_of(text))) == BlobPut::created);
      CHECK(text_of(*got(stores.blobs.open(key))) == text);
    }
  }
}

TEST_CASE("S3 in trouble: stale reads miss what is new, and give no other bytes") {
  Stores stores;
  const BlobKey fresh = key_of("ann", "fresh");
  CHECK(got(stores.blobs.put(fresh, bytes_of("fresh"))) == BlobPut::created);
  stores.server.fail("GET", kBlob, "stale", 1);
  CHECK_FALSE(got(stores.blobs.open(fresh)).has_value());
  CHECK(text_of(*got(stores.blobs.open(fresh))) == "fresh");
  stores.server.fail("HEAD", kBlob, "stale", 1);
  CHECK_FALSE(got(stores.blobs.exists(fresh)));
  stores.server.fail("HEAD", kBlob, "stale", 1);
  CHECK(got(stores.blobs.put(fresh, bytes_of("fresh"))) == BlobPut::created);
  CHECK(got(stores.blobs.exists(fresh)));

  const BlobKey mended = key_of("ann", "mended");
  stores.server.control("plant", {{{"key", stores.server.settings().prefix + "/" + blob_name(mended)}, {"text", "!"}}});
  CHECK(got(stores.blobs.put(mended, bytes_of("mended"))) == BlobPut::created);
  stores.server.fail("GET", kBlob, "stale", 1);
  CHECK(text_of(*got(stores.blobs.open(mended))) == "mended");

  CHECK(got(stores.blobs.remove(fresh)));
  stores.server.fail("GET", "list-type", "stale", 1);
  const std::vector<BlobKey> used{mended};
  CHECK(got(stores.blobs.remove_unused(used, 0s)) == 0);
  CHECK(got(stores.blobs.exists(mended)));
}

TEST_CASE("S3 in trouble: a slow server is waited for while bytes come") {
  const S3Double server;
  S3Limits limits = limits_for_tests();
  limits.stall = 1s;  // less than the whole body takes
  S3Blobs blobs(server.settings(), options_for_tests(), limits);
  const std::string text = long_text(1'000'000);
  const BlobKey key = key_of("ann", text);
  nlohmann::json faults = nlohmann::json::array();
  for (const char* method : {"PUT", "HEAD", "GET", "DELETE"}) {
    faults.push_back({{"method", method}, {"match", kBlob}, {"times", 100}, {"what", "slow"}, {"seconds", 0.15}});
  }
  server.control("faults", faults);
  CHECK(got(blobs.put(key, bytes_of(text))) == BlobPut::created);
  CHECK(got(blobs.exists(key)));
  std::string read;
  CHECK(got(blobs.fetch(key, [&](std::span<const std::byte> piece) -> Result<Done> {
    read.append(reinterpret_cast<const char*>(piece.data()), piece.size());
    return Done{};
  })));
  CHECK(read == text);
  CHECK(got(blobs.remove(key)));
  CHECK_FALSE(got(blobs.exists(key)));
}

TEST_CASE("S3 in trouble: cached blobs are readable without S3") {
  Stores stores;
  const BlobKey key = key_of("ann", "x");
  got(stores.blobs.put(key, bytes_of("x")));
  CHECK(got(stores.blobs.open(key)).has_value());
  for (const char* method : {"GET", "HEAD"}) stores.server.fail(method, "", "slow_down", 100);
  CHECK(text_of(*got(stores.blobs.open(key))) == "x");
}

TEST_CASE("S3 in trouble: a silent server ends in a timeout") {
  const S3Double server;
  S3Limits limits = limits_for_tests();
  limits.small = limits.stall = 1s;
  limits.attempts = 1;
  S3Blobs blobs(server.settings(), options_for_tests(), limits);
  nlohmann::json faults = nlohmann::json::array();
  for (const char* method : {"GET", "HEAD"}) {
    faults.push_back({{"method", method}, {"match", ""}, {"times", 1}, {"what", "stall"}, {"seconds", 30}});
  }
  server.control("faults", faults);
  const BlobKey key = key_of("ann", "x");
  CHECK(code_of(blobs.exists(key)) == ErrorCode::storage_unavailable);
  CHECK(code_of(blobs.fetch(key, [](auto) { return Result<Done>(Done{}); })) == ErrorCode::storage_unavailable);
  CHECK_FALSE(got(blobs.exists(key)));
}

TEST_CASE("S3 in trouble: a body that stalls is continued over another connection") {
  const S3Double server;
  S3Limits limits = limits_for_tests();
  limits.stall = 1s;
  S3Blobs blobs(server.settings(), options_for_tests(), limits);
  const std::string text = long_text(1'000'000);
  const BlobKey key = key_of("ann", text);
  got(blobs.put(key, bytes_of(text)));
  server.control("faults",
                 {{{"method", "GET"}, {"match", kBlob}, {"times", 1}, {"what", "stall_body"}, {"seconds", 30}}});
  std::string read;
  CHECK(got(blobs.fetch(key, [&](std::span<const std::byte> piece) -> Result<Done> {
    read.append(reinterpret_cast<const char*>(piece.data()), piece.size());
    return Done{};
  })));
  CHECK(read == text);
}

TEST_CASE("S3 in trouble: no server listens") {
  S3Settings settings;
  {
    const S3Double gone;
    settings = gone.settings();
  }
  S3Blobs blobs(settings, options_for_tests(), limits_for_tests());
  CHECK(code_of(blobs.exists(key_of("ann", "x"))) == ErrorCode::storage_unavailable);
  CHECK(code_of(blobs.check()) == ErrorCode::storage_unavailable);
}

TEST_CASE("S3 in trouble: many threads at once, with every twentieth request lost") {
  Stores stores;
  stores.server.control("settings", {{"page", 5}});
  std::atomic<int> wrong{0};
  {
    std::vector<std::jthread> threads;
    for (int t = 0; t < 8; ++t) {
      threads.emplace_back([&, t] {
        for (int i = 0; i < 10; ++i) {
          const std::string text = std::to_string(i % 5) + long_text(1000);
          const BlobKey key = key_of(t % 2 == 0 ? "ann" : "bob", text);
          const bool stored = stores.blobs.put(key, bytes_of(text)).ok();
          const auto blob = stores.blobs.open(key);
          if (!stored || !blob || !*blob || text_of(**blob) != text) ++wrong;
        }
      });
    }
    for (int i = 0; i < 8; ++i) {
      stores.server.fail(i % 2 == 0 ? "PUT" : "GET", "", i % 4 < 2 ? "reset" : "slow_down", 1);
      std::this_thread::sleep_for(5ms);
    }
  }
  CHECK(wrong == 0);
  CHECK(stores.blobs.cache().counters().files == 10);
  CHECK(got(stores.blobs.stored_bytes("ann")) == 5 * 1001);
}
