#include "server/store/mesh_index.h"

#include <limits>

#include "implementations.h"

using namespace meshgauge;
using namespace meshgauge::server::store;

namespace {

constexpr std::uint64_t kNoLimit = std::numeric_limits<std::int64_t>::max();

MeshRow mesh(const std::string& owner, const std::string& id, std::uint64_t bytes = 10) {
  return {{owner, id}, bytes, "model/stl", "a \"b\".stl", at(0), at(1), at(100)};
}

}  // namespace

TEST_CASE_TEMPLATE("meshes: put, read, deleted; each owner has its own", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  const PutMesh put = got(stores.meshes().put_mesh(mesh("ann", "m"), {kNoLimit}));
  CHECK(put.what == MeshPut::created);
  CHECK(put.row == mesh("ann", "m"));
  CHECK(got(stores.meshes().put_mesh(mesh("bob", "m", 99), {kNoLimit})).what == MeshPut::created);
  stores.reopen();
  CHECK(got(stores.meshes().get_mesh({"ann", "m"})) == mesh("ann", "m"));
  CHECK_FALSE(got(stores.meshes().get_mesh({"", "m"})).has_value());
  CHECK(got(stores.meshes().stored("ann")).bytes == 10);
  CHECK(got(stores.meshes().stored("")).bytes == 0);
  CHECK(got(stores.meshes().all_stored_bytes()) == 109);
  CHECK(got(stores.meshes().delete_mesh({"ann", "m"})));
  CHECK_FALSE(got(stores.meshes().delete_mesh({"ann", "m"})));
  CHECK_FALSE(got(stores.meshes().get_mesh({"ann", "m"})).has_value());
  CHECK(got(stores.meshes().stored("ann")).bytes == 0);
  CHECK(got(stores.meshes().stored("bob")).bytes == 99);
  CHECK(got(stores.meshes().all_stored_bytes()) == 99);
}

TEST_CASE_TEMPLATE("meshes: a repeated put renews the times alone", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  got(stores.meshes().put_mesh(mesh("ann", "m"), {10}));
  MeshRow again = mesh("ann", "m");
  again.media_type = "model/obj";
  again.created = at(50);
  again.last_used = at(60);
  again.expires = at(160);
  const PutMesh put = got(stores.meshes().put_mesh(again, {10}));  // takes no more room
  CHECK(put.what == MeshPut::existed);
  MeshRow expected = mesh("ann", "m");
  expected.last_used = at(60);
  expected.expires = at(160);
  CHECK(put.row == expected);
  again.last_used = at(55);
  again.expires = at(155);
  CHECK(got(stores.meshes().put_mesh(again, {10})).row == expected);  // no time goes back
  CHECK(got(stores.meshes().stored("ann")).bytes == 10);
}

TEST_CASE_TEMPLATE("meshes: a quota holds to the byte", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  CHECK(got(stores.meshes().put_mesh(mesh("ann", "1", 60), {100})).what == MeshPut::created);
  CHECK(got(stores.meshes().put_mesh(mesh("ann", "2", 41), {100})).what == MeshPut::over_quota);
  CHECK(got(stores.meshes().put_mesh(mesh("ann", "3", 101), {100})).what == MeshPut::over_quota);
  CHECK(got(stores.meshes().put_mesh(mesh("ann", "4", 40), {100})).what == MeshPut::created);
  CHECK(got(stores.meshes().put_mesh(mesh("ann", "5", 1), {100})).what == MeshPut::over_quota);
  CHECK(got(stores.meshes().put_mesh(mesh("bob", "5", 1), {100})).what == MeshPut::created);
  CHECK_FALSE(got(stores.meshes().get_mesh({"ann", "2"})).has_value());
  CHECK(got(stores.meshes().delete_mesh({"ann", "1"})));
  CHECK(got(stores.meshes().put_mesh(mesh("ann", "5", 60), {100})).what == MeshPut::created);
  CHECK(got(stores.meshes().stored("ann")).bytes == 100);
}

TEST_CASE_TEMPLATE("meshes: an owner has no more of them than its quota says", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  constexpr MeshQuota two = {1000, 2};
  CHECK(got(stores.meshes().put_mesh(mesh("ann", "1"), two)).what == MeshPut::created);
  CHECK(got(stores.meshes().put_mesh(mesh("ann", "2"), two)).what == MeshPut::created);
  CHECK(got(stores.meshes().put_mesh(mesh("ann", "3"), two)).what == MeshPut::too_many);
  CHECK(got(stores.meshes().put_mesh(mesh("ann", "2"), two)).what == MeshPut::existed);
  CHECK(got(stores.meshes().put_mesh(mesh("bob", "3"), two)).what == MeshPut::created);
  CHECK(got(stores.meshes().stored("ann")).meshes == 2);
  CHECK(got(stores.meshes().delete_mesh({"ann", "1"})));
  CHECK(got(stores.meshes().put_mesh(mesh("ann", "3"), two)).what == MeshPut::created);
  CHECK(got(stores.meshes().sweep_meshes(at(100))).size() == 3);
  CHECK(got(stores.meshes().stored("ann")).meshes == 0);
}

TEST_CASE_TEMPLATE("meshes: used ones are kept, the others swept", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  for (const char* id : {"1", "2", "3"}) got(stores.meshes().put_mesh(mesh("ann", id), {kNoLimit}));
  stores.meshes().touch_mesh({"ann", "2"}, at(50), at(200));
  stores.meshes().touch_mesh({"ann", "2"}, at(40), at(140));  // came later, is older
  stores.meshes().touch_mesh({"ann", "unknown"}, at(50), at(200));
  CHECK(got(stores.meshes().sweep_meshes(at(99))).empty());
  CHECK(got(stores.meshes().sweep_meshes(at(100))).size() == 2);
  const std::optional<MeshRow> kept = got(stores.meshes().get_mesh({"ann", "2"}));
  REQUIRE(kept.has_value());
  CHECK(kept->last_used == at(50));
  CHECK(kept->expires == at(200));
  CHECK(got(stores.meshes().stored("ann")).bytes == 10);
  stores.meshes().touch_mesh({"ann", "2"}, at(60), at(300));
  got(stores.jobs().flush());
  CHECK(got(stores.meshes().get_mesh({"ann", "2"}))->expires == at(300));
}
