#include "server/store/blob_store.h"

#include <fcntl.h>
#include <stdlib.h>
#include <unistd.h>

#include <filesystem>
#include <thread>

#include "implementations.h"
#include "s3/s3_for_tests.h"

using namespace meshgauge;
using namespace meshgauge::server::store;
using meshgauge::Descriptor;

namespace {

using namespace std::chrono_literals;

// Stores with another clock have an overload of their own.
template <class Stores>
void pass_time(Stores& stores, std::chrono::milliseconds time) {
  if constexpr (requires { stores.pass_time(time); }) {
    stores.pass_time(time);
  } else {
    std::this_thread::sleep_for(time);
  }
}

}  // namespace

TEST_CASE_TEMPLATE("blobs: bytes that were put are read back", Stores, EVERY_BLOB_STORE) {
  Stores stores;
  const std::string texts[] = {
      "", "x", long_text((1 << 20) - 1), long_text(1 << 20), long_text((1 << 20) + 1), long_text(5'000'000)};
  for (const std::string& text : texts) {
    for (const std::string owner : {"", "../bob", "ann"}) {
      const BlobKey key = key_of(owner, text);
      CHECK_FALSE(got(stores.blobs().exists(key)));
      CHECK(got(stores.blobs().put(key, bytes_of(text))) == BlobPut::created);
      CHECK(got(stores.blobs().put(key, bytes_of(text))) == BlobPut::existed);
    }
  }
  stores.reopen();
  for (const std::string& text : texts) {
    for (const std::string owner : {"", "../bob", "ann"}) {
      const BlobKey key = key_of(owner, text);
      CHECK(got(stores.blobs().exists(key)));
      const std::optional<Blob> blob = got(stores.blobs().open(key));
      REQUIRE(blob.has_value());
      CHECK(blob->size() == text.size());
      CHECK(text_of(*blob) == text);
      std::string read(text.size(), '\0');
      CHECK(::pread(blob->file(), read.data(), read.size(), 0) == static_cast<ssize_t>(text.size()));
      CHECK(read == text);
      CHECK(::pwrite(blob->file(), "y", 1, 0) < 0);
    }
  }
}

TEST_CASE_TEMPLATE("blobs: bytes with another digest are not stored", Stores, EVERY_BLOB_STORE) {
  Stores stores;
  const BlobKey key = key_of("ann", "right");
  CHECK(got(stores.blobs().put(key, bytes_of("wrong"))) == BlobPut::other_digest);
  CHECK(got(stores.blobs().put(key, bytes_of("longer"))) == BlobPut::other_digest);
  CHECK_FALSE(got(stores.blobs().exists(key)));
  CHECK(got(stores.blobs().put(key, bytes_of("right"))) == BlobPut::created);
  CHECK(got(stores.blobs().put(key, bytes_of("wrong"))) == BlobPut::other_digest);
  CHECK(text_of(*got(stores.blobs().open(key))) == "right");
}

TEST_CASE_TEMPLATE("blobs: a text that is no digest names no blob", Stores, EVERY_BLOB_STORE) {
  Stores stores;
  got(stores.blobs().put(key_of("ann", "x"), bytes_of("x")));
  const std::string id = key_of("ann", "x").id;
  std::string upper = id;
  for (char& c : upper) c = static_cast<char>(c >= 'a' ? c - 32 : c);
  for (const std::string& name : {std::string(), std::string("../../lock"), id.substr(1), id + "0", upper,
                                  "/" + id.substr(1), id.substr(0, 32) + std::string(1, '\0') + id.substr(33)}) {
    const BlobKey key{"ann", name};
    CHECK(got(stores.blobs().put(key, bytes_of("x"))) == BlobPut::other_digest);
    CHECK_FALSE(got(stores.blobs().open(key)).has_value());
    CHECK_FALSE(got(stores.blobs().exists(key)));
    CHECK_FALSE(got(stores.blobs().renew(key)));
    CHECK_FALSE(got(stores.blobs().remove(key)));
  }
}

TEST_CASE_TEMPLATE("blobs: each owner has its own, and open ones stay readable when they are removed", Stores,
                   EVERY_BLOB_STORE) {
  Stores stores;
  const std::string text = long_text(3'000'000);
  const BlobKey anns = key_of("ann", text);
  const BlobKey bobs = key_of("bob", text);
  got(stores.blobs().put(anns, bytes_of(text)));
  CHECK_FALSE(got(stores.blobs().exists(bobs)));
  CHECK_FALSE(got(stores.blobs().open(bobs)).has_value());
  CHECK_FALSE(got(stores.blobs().remove(bobs)));
  CHECK(got(stores.blobs().put(bobs, bytes_of(text))) == BlobPut::created);
  const std::optional<Blob> blob = got(stores.blobs().open(anns));
  CHECK(got(stores.blobs().remove(anns)));
  CHECK_FALSE(got(stores.blobs().remove(anns)));
  CHECK_FALSE(got(stores.blobs().exists(anns)));
  CHECK(got(stores.blobs().exists(bobs)));
  CHECK(text_of(*blob) == text);
}

TEST_CASE_TEMPLATE("blobs: unused ones are removed, young ones are not", Stores, EVERY_BLOB_STORE) {
  Stores stores;
  const BlobKey used = key_of("ann", "used");
  const BlobKey unused = key_of("ann", "unused");
  for (const char* owner : {"ann", "bob"}) {
    for (const char* text : {"used", "unused"}) got(stores.blobs().put(key_of(owner, text), bytes_of(text)));
  }
  CHECK(got(stores.blobs().remove_unused(std::vector{used}, 3600s)) == 0);
  CHECK(got(stores.blobs().remove_unused(std::vector{used, BlobKey{"ann", "x"}}, 0s)) == 3);
  CHECK(got(stores.blobs().exists(used)));
  CHECK_FALSE(got(stores.blobs().exists(unused)));
  CHECK_FALSE(got(stores.blobs().exists(key_of("bob", "used"))));
  CHECK(got(stores.blobs().put(unused, bytes_of("unused"))) == BlobPut::created);
  pass_time(stores, 1100ms);
  CHECK(got(stores.blobs().renew(used)));
  CHECK_FALSE(got(stores.blobs().renew(key_of("bob", "used"))));
  CHECK(got(stores.blobs().remove_unused({}, 1s)) == 1);
  CHECK(got(stores.blobs().exists(used)));
  CHECK_FALSE(got(stores.blobs().exists(unused)));
}

// Like the files of a batch, which may come long before its row.
TEST_CASE_TEMPLATE("blobs: a blob that is renewed while reserved survives sweeps with older lists", Stores,
                   EVERY_BLOB_STORE) {
  constexpr int kBlobs = 40;
  Stores stores;
  BlobStore& blobs = stores.blobs();
  const auto nth = [](int i) { return "blob " + std::to_string(i); };
  const auto renew = [&](int i) {
    const auto held = blobs.reserve(key_of("ann", nth(i)));
    return got(blobs.renew(key_of("ann", nth(i))));
  };
  for (int i = 0; i < 2 * kBlobs; ++i) got(blobs.put(key_of("ann", nth(i)), bytes_of(nth(i))));
  pass_time(stores, 2100ms);
  for (int i = 0; i < kBlobs; ++i) CHECK(renew(i));
  std::uint64_t removed = 0;
  std::thread sweep([&] { removed = got(blobs.remove_unused({}, 2s)); });
  std::uint64_t kept = 0;
  for (int i = 2 * kBlobs - 1; i >= kBlobs; --i) {
    const bool renewed = renew(i);
    CHECK(got(blobs.exists(key_of("ann", nth(i)))) == renewed);
    kept += renewed ? 1 : 0;
  }
  sweep.join();
  CHECK(removed + kept == kBlobs);
  for (int i = 0; i < kBlobs; ++i) CHECK(got(blobs.exists(key_of("ann", nth(i)))));
}

TEST_CASE_TEMPLATE("blobs: an unreferenced blob is removed at once, unless it is reserved", Stores, EVERY_BLOB_STORE) {
  Stores stores;
  BlobStore& blobs = stores.blobs();
  const BlobKey key = key_of("ann", "x");
  const auto yes = [] { return Result<bool>(true); };
  const auto no = [] { return Result<bool>(false); };
  CHECK_FALSE(got(blobs.remove_unreferenced(key, no)));
  got(blobs.put(key, bytes_of("x")));
  CHECK_FALSE(got(blobs.remove_unreferenced(key, yes)));
  CHECK_FALSE(blobs.remove_unreferenced(key, [] { return Error{ErrorCode::internal, "it is unknown", "", ""}; }).ok());
  {
    const auto first = blobs.reserve(key);
    { const auto second = blobs.reserve(key); }
    CHECK_FALSE(got(blobs.remove_unreferenced(key, no)));
    CHECK_FALSE(got(blobs.remove_unreferenced(key_of("bob", "x"), no)));
  }
  CHECK(got(blobs.exists(key)));
  CHECK(got(blobs.remove_unreferenced(key, no)));
  CHECK_FALSE(got(blobs.exists(key)));
}

TEST_CASE_TEMPLATE("blobs: the bytes of an owner are counted through puts, removals, sweeps and a start", Stores,
                   EVERY_BLOB_STORE) {
  Stores stores;
  const auto bytes = [&](const char* owner) { return got(stores.blobs().stored_bytes(owner)); };
  CHECK(bytes("ann") == 0);
  for (const char* text : {"one", "three", "seven", "three"}) {
    got(stores.blobs().put(key_of("ann", text), bytes_of(text)));
  }
  got(stores.blobs().put(key_of("bob", "one"), bytes_of("one")));
  CHECK(got(stores.blobs().put(key_of("ann", "right"), bytes_of("wrong"))) == BlobPut::other_digest);
  CHECK(bytes("ann") == 13);
  CHECK(bytes("bob") == 3);
  stores.reopen();
  CHECK(bytes("ann") == 13);
  got(stores.blobs().remove(key_of("ann", "one")));
  got(stores.blobs().remove(key_of("ann", "one")));
  CHECK(bytes("ann") == 10);
  got(stores.blobs().remove_unreferenced(key_of("ann", "three"), [] { return Result<bool>(false); }));
  CHECK(bytes("ann") == 5);
  got(stores.blobs().remove_unused({}, 0s));
  CHECK(bytes("ann") == 0);
  CHECK(bytes("bob") == 0);
}

TEST_CASE_TEMPLATE("blobs: free room is reported", Stores, EVERY_BLOB_STORE) {
  Stores stores;
  const std::uint64_t free = got(stores.blobs().free_bytes());
  CHECK((free > 0 || std::filesystem::space(std::filesystem::temp_directory_path()).available == 0));
}
