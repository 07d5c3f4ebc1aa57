// S3Blobs against the double: its requests, accepted signatures, and many objects. The suite of BlobStore
// (blob_store_test.cpp) runs over it as well. OwnerSums needs no server.
#include "server/store/s3/s3_blobs.h"

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <functional>
#include <new>
#include <thread>
#include <utility>
#include <vector>

#include "../store_text.h"
#include "s3_for_tests.h"

using namespace meshgauge;
using namespace meshgauge::server::store;
using namespace std::chrono_literals;

namespace {

Reservations none_reserved;

S3Blobs blobs_of(const S3Double& server, S3BlobOptions options = options_for_tests()) {
  return S3Blobs(server.settings(), options, limits_for_tests());
}

std::string fetched(S3Blobs& blobs, const BlobKey& key) {
  std::string text;
  const bool found = got(blobs.fetch(key, [&](std::span<const std::byte> piece) -> Result<Done> {
    text.append(reinterpret_cast<const char*>(piece.data()), piece.size());
    return Done{};
  }));
  return found ? text : "none";
}

// Renews a blob that was listed, before it is removed.
class RenewsOne final : public Reservations {
 public:
  RenewsOne(S3Blobs& blobs, BlobKey key) : blobs_(blobs), key_(std::move(key)) {}

  Result<bool> unless_held(const std::string& name, const std::function<Result<bool>()>& work) override {
    if (name == blob_name(key_)) REQUIRE(got(blobs_.renew(key_)));
    return Reservations::unless_held(name, work);
  }

 private:
  S3Blobs& blobs_;
  const BlobKey key_;
};

std::string refusal_of(const S3Settings& settings) {
  S3Blobs blobs(settings, options_for_tests(), limits_for_tests());
  const Result<BlobPut> put = blobs.put(key_of("ann", "x"), bytes_of("x"));
  if (put) return "";
  CHECK(put.error().code == ErrorCode::storage_unavailable);
  return put.error().message;
}

void round_trip(const S3Settings& settings) {
  S3Blobs blobs(settings, options_for_tests(), limits_for_tests());
  const std::string text = long_text(100'000);
  const BlobKey key = key_of("ann", text);
  CHECK(got(blobs.put(key, bytes_of(text))) == BlobPut::created);
  CHECK(fetched(blobs, key) == text);
  CHECK(got(blobs.stored_bytes("ann")) == text.size());
  CHECK(got(blobs.remove_unused({}, 0s, none_reserved)) == 1);
  CHECK(fetched(blobs, key) == "none");
}

}  // namespace

TEST_CASE("S3: with a session token, in virtual-host style, without a prefix") {
  const S3Double with_token({"a/token+with=signs", false, false});
  round_trip(with_token.settings());
  const S3Double by_host({"", false, true});
  round_trip(by_host.settings());
  S3Settings bare = by_host.settings();
  bare.prefix.clear();
  round_trip(bare);
}

TEST_CASE("S3: over TLS, with a certificate that is trusted, and not without") {
  const S3Double server({"", true, false});
  round_trip(server.settings());
  S3Settings untrusting = server.settings();
  untrusting.ca_file.clear();
  CHECK(refusal_of(untrusting).find("cannot be reached") != std::string::npos);
}

TEST_CASE("S3: wrong keys, tokens, regions, buckets and clocks are refused, and the refusal says which") {
  const S3Double server;
  const auto with = [&](auto change) {
    S3Settings settings = server.settings();
    change(settings);
    return refusal_of(settings);
  };
  const auto says = [](const std::string& text, const char* what) { return text.find(what) != std::string::npos; };
  CHECK(with([](S3Settings&) {}).empty());
  CHECK(says(with([](S3Settings& s) { s.credentials.secret_key += "x"; }), "403"));
  CHECK(says(with([](S3Settings& s) { s.credentials.access_key = "OTHER"; }), "403"));
  CHECK(says(with([](S3Settings& s) { s.credentials.session_token = "OTHER"; }), "403"));
  S3Settings wrong_region = server.settings();
  wrong_region.region = "us-east-1";
  S3Blobs elsewhere(wrong_region, options_for_tests(), limits_for_tests());
  const Result<Done> checked = elsewhere.check();  // sent with a body to answer in
  REQUIRE_FALSE(checked.ok());
  CHECK(says(checked.error().message, "AuthorizationHeaderMalformed"));
  CHECK(says(with([](S3Settings& s) { s.bucket = "another"; }), "NoSuchBucket"));
  server.control("settings", {{"ahead", 1000}});
  S3Blobs late = blobs_of(server);
  const Result<Done> too_late = late.check();
  REQUIRE_FALSE(too_late.ok());
  CHECK(too_late.error().code == ErrorCode::storage_unavailable);
  CHECK(says(too_late.error().message, "clocks"));
}

TEST_CASE("S3: a sound object is renewed, one without a checksum is sent again") {
  const S3Double server;
  S3Blobs blobs = blobs_of(server);
  const BlobKey key = key_of("ann", "right");
  const std::string object = server.settings().prefix + "/" + blob_name(key);
  got(blobs.put(key, bytes_of("right")));
  server.count("GET", "");
  CHECK(got(blobs.put(key, bytes_of("right"))) == BlobPut::existed);
  server.control("settings", {{"checksums", false}});
  CHECK(got(blobs.put(key, bytes_of("right"))) == BlobPut::existed);
  std::uint64_t sent = 0;
  for (const auto& request : server.control("log", nullptr)) sent += request["bytes"].get<std::uint64_t>();
  CHECK(sent == 5);  // once, of two
  for (const bool checksums : {true, false}) {
    server.control("settings", {{"checksums", checksums}});
    server.control("plant", {{{"key", object}, {"text", "wrong"}}});
    got(blobs.put(key, bytes_of("right")));
    CHECK(fetched(blobs, key) == "right");
  }
  server.control("plant", {{{"key", object}, {"text", "too long"}}});
  CHECK(got(blobs.put(key, bytes_of("right"))) == BlobPut::created);
  CHECK(fetched(blobs, key) == "right");
}

TEST_CASE("S3: a young blob is not copied for each job, and kept for as much longer") {
  const S3Double server;
  S3BlobOptions options = options_for_tests();
  options.young = 60s;
  S3Blobs blobs = blobs_of(server, options);
  const BlobKey key = key_of("ann", "x");
  got(blobs.put(key, bytes_of("x")));
  server.count("PUT", "");
  CHECK(got(blobs.renew(key)));
  CHECK(server.count("PUT", "") == 0);
  server.control("age", 55);
  CHECK(got(blobs.remove_unused({}, 0s, none_reserved)) == 0);
  server.control("age", 10);
  CHECK(got(blobs.renew(key)));
  CHECK(server.count("PUT", "") == 1);
  CHECK(got(blobs.remove_unused({}, 0s, none_reserved)) == 0);
  server.control("age", 65);
  CHECK(got(blobs.remove_unused({}, 0s, none_reserved)) == 1);
}

TEST_CASE("S3: many pages, and objects of others stay") {
  const S3Double server;
  S3Blobs blobs = blobs_of(server);
  server.control("settings", {{"page", 7}});
  const std::string root = server.settings().prefix + "/";
  const std::string owner = blob_name({"ann", ""}).substr(0, 64);
  nlohmann::json plants = nlohmann::json::array();
  std::vector<BlobKey> keys;
  for (int i = 0; i < 60; ++i) {
    keys.push_back(key_of("ann", std::to_string(i)));
    plants.push_back({{"key", root + blob_name(keys.back())}, {"text", std::to_string(i % 10)}, {"age_s", 1000}});
  }
  for (const char* other : {"check", "notes.txt", "ab/cd/ef"}) plants.push_back({{"key", root + other}, {"text", "?"}});
  plants.push_back({{"key", "elsewhere/" + blob_name(keys[0])}, {"text", "?"}, {"age_s", 1000}});
  plants.push_back({{"key", root + owner + "/zz/" + keys[0].id}, {"text", "??"}, {"age_s", 1000}});
  server.control("plant", plants);
  CHECK(got(blobs.stored_bytes("ann")) == 62);
  server.count("GET", "");
  CHECK(got(blobs.remove_unused(std::span(keys).first(20), 10s, none_reserved)) == 40);
  CHECK(server.count("GET", "list-type") == 10);
  CHECK(got(blobs.stored_bytes("ann")) == 22);
  CHECK(got(blobs.remove_unused({}, 2000s, none_reserved)) == 0);
  CHECK(got(blobs.remove_unused({}, 10s, none_reserved)) == 20);
  CHECK(server.control("state", nullptr)["objects"].size() == 5);
}

TEST_CASE("S3: a blob that is renewed or reserved between listing and removal stays") {
  const S3Double server;
  S3Blobs blobs = blobs_of(server);
  for (const char* text : {"a", "b", "c"}) got(blobs.put(key_of("ann", text), bytes_of(text)));
  server.control("age", 100);
  RenewsOne reservations(blobs, key_of("ann", "b"));
  const Reservations::Held held(reservations, key_of("ann", "a"));
  CHECK(got(blobs.remove_unused({}, 10s, reservations)) == 1);
  CHECK(got(blobs.exists(key_of("ann", "a"))));
  CHECK(got(blobs.exists(key_of("ann", "b"))));
  CHECK_FALSE(got(blobs.exists(key_of("ann", "c"))));
}

TEST_CASE("S3: abandoned uploads are aborted") {
  const S3Double server;
  server.control("settings", {{"least_part", 1 << 20}, {"page", 1}});
  S3BlobOptions options = options_for_tests();
  options.abandoned = 3600s;
  S3Blobs blobs = blobs_of(server, options);
  S3Client client(server.settings(), limits_for_tests());
  for (const char* text : {"a", "b", "c"}) {
    CHECK(client.begin_upload(server.settings().prefix + "/" + blob_name(key_of("ann", text))).ok());
  }
  CHECK(client.begin_upload("another's").ok());
  got(blobs.remove_unused({}, 0s, none_reserved));
  CHECK(server.control("state", nullptr)["uploads"].size() == 4);
  server.control("age", 3700);
  got(blobs.remove_unused({}, 0s, none_reserved));
  CHECK(server.control("state", nullptr)["uploads"] == nlohmann::json{"another's"});
}

TEST_CASE("S3: parts are sent several at once, and no more than that") {
  const S3Double server;
  server.control("settings", {{"least_part", 1 << 20}});
  S3BlobOptions options = options_for_tests();
  options.parts_at_once = 3;
  S3Blobs blobs = blobs_of(server, options);
  const std::string text = long_text(12'345'678);
  const BlobKey key = key_of("ann", text);
  // No answer before three of them have arrived.
  server.control("faults",
                 {{{"method", "PUT"}, {"match", "partNumber="}, {"times", 3}, {"what", "gather"}, {"count", 3}}});
  CHECK(got(blobs.put(key, bytes_of(text))) == BlobPut::created);
  CHECK(server.control("state", nullptr)["most_parts"] == 3);
  CHECK(server.count("PUT", "partNumber=") == 12);
  CHECK(fetched(blobs, key) == text);
}

TEST_CASE("S3, any server: missing objects, abandoned uploads, wrong bytes and keys") {
  std::optional<S3Double> server;
  const S3Settings settings = settings_for_tests(server);
  S3Client client(settings, limits_for_tests());
  S3BlobOptions options = options_for_tests();
  options.abandoned = 0s;
  S3Blobs blobs(settings, options, limits_for_tests());
  const std::string text = long_text(1 << 20);
  const BlobKey key = key_of("ann", text);
  const std::string object = settings.prefix + "/" + blob_name(key);
  const auto bytes = bytes_of(text);
  const auto nothing = [](auto) { return Result<Done>(Done{}); };

  CHECK_FALSE(got(client.get(object, nothing)));
  CHECK_FALSE(got(client.copy_onto_itself(object)));
  CHECK(client.remove(object).ok());
  const std::string left = got(client.begin_upload(object));
  const std::string etag = got(client.put_part(object, left, 1, bytes, key.id));
  CHECK(got(client.list_uploads(settings.prefix + "/", "", "")).uploads.size() == 1);
  CHECK(got(blobs.remove_unused({}, 0s, none_reserved)) == 0);
  CHECK(got(client.list_uploads(settings.prefix + "/", "", "")).uploads.empty());
  CHECK(client.abort_upload(object, left).ok());
  const Result<bool> aborted = client.complete_upload(object, left, {etag});  // Ceph 16 has an InternalError for it
  CHECK_FALSE((aborted && *aborted));
  const std::string upload = got(client.begin_upload(object));
  const std::string same_etag = got(client.put_part(object, upload, 1, bytes, key.id));
  CHECK(got(client.complete_upload(object, upload, {same_etag})));
  CHECK(client.complete_upload(object, upload, {same_etag}).ok());  // as when the answer was lost
  CHECK(got(client.head(object))->size == text.size());
  CHECK(client.remove(object).ok());

  CHECK_FALSE(client.put(object, bytes, key_of("ann", "other").id).ok());
  CHECK_FALSE(got(client.head(object)).has_value());
  CHECK(client.put(object, bytes, key.id).ok());
  CHECK(got(client.head(object))->size == text.size());
  S3Settings wrong = settings;
  wrong.credentials.secret_key += "x";
  CHECK(refusal_of(wrong).find("403") != std::string::npos);
  wrong = settings;
  wrong.bucket = "another-bucket-of-tests";
  CHECK(refusal_of(wrong).find("S3 answers 40") != std::string::npos);
  CHECK(got(blobs.remove_unused({}, 0s, none_reserved)) == 1);
}

TEST_CASE("S3: one connection serves one request after another") {
  const S3Double server;
  S3Blobs blobs = blobs_of(server);
  for (int i = 0; i < 10; ++i) {
    const std::string text = std::to_string(i);
    got(blobs.put(key_of("ann", text), bytes_of(text)));
  }
  const nlohmann::json log = server.control("log", nullptr);
  CHECK(log.size() == 20);
  for (const auto& request : log) CHECK(request["peer"] == log[0]["peer"]);
}

TEST_CASE("sums of owners: listed once, then kept up") {
  std::atomic<int> listings{0};
  OwnerSums sums([&](const std::string& owner) -> Result<std::uint64_t> {
    ++listings;
    return owner == "ann" ? 100 : 7;
  });
  sums.add("ann", 5);  // the next listing has it
  CHECK(got(sums.of("ann")) == 100);
  sums.add("ann", 20);
  sums.remove("ann", 50);
  CHECK(got(sums.of("ann")) == 70);
  CHECK(got(sums.of("bob")) == 7);
  sums.remove("bob", 8);
  CHECK(got(sums.of("bob")) == 0);
  CHECK(listings == 2);
}

TEST_CASE("sums of owners: a failed listing is repeated") {
  std::atomic<bool> down{true};
  OwnerSums sums([&](const std::string&) -> Result<std::uint64_t> {
    if (down) return Error{ErrorCode::storage_unavailable, "down", "", ""};
    return 3;
  });
  CHECK_FALSE(sums.of("ann").ok());
  down = false;
  CHECK(got(sums.of("ann")) == 3);
}

TEST_CASE("sums of owners: a listing that throws blocks neither waiting nor later calls") {
  std::atomic<int> listings{0};
  OwnerSums sums(
      [&](const std::string&) -> Result<std::uint64_t> {
        const int listing = ++listings;
        if (listing == 1 || listing == 3) throw std::bad_alloc();
        return static_cast<std::uint64_t>(listing);
      },
      0ms);
  CHECK_FALSE(sums.of("ann").ok());
  CHECK(got(sums.of("ann")) == 2);
  std::uint64_t now = 2;
  while (now == 2) now = got(sums.of("ann"));  // after the third listing, which fails in the background
  CHECK(now >= 4);
}

TEST_CASE("sums of owners: an old sum is returned during a new listing, and puts meanwhile count") {
  std::atomic<bool> go_on{true};
  std::atomic<int> listings{0};
  OwnerSums sums(
      [&](const std::string&) -> Result<std::uint64_t> {
        ++listings;
        while (!go_on) std::this_thread::sleep_for(1ms);
        return listings == 1 ? 10 : 1000;
      },
      0ms);
  CHECK(got(sums.of("ann")) == 10);
  go_on = false;
  while (listings < 2) {
    const std::uint64_t now = got(sums.of("ann"));  // begins a listing at some time
    CHECK(now == 10);
  }
  sums.add("ann", 5);
  CHECK(got(sums.of("ann")) == 15);
  go_on = true;
  std::uint64_t now = 15;
  while (now == 15) now = got(sums.of("ann"));
  CHECK(now == 1005);
}
