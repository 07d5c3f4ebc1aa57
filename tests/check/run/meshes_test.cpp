#include "check/run/meshes.h"

#include <doctest/doctest.h>

#include <atomic>
#include <filesystem>
#include <memory>
#include <thread>
#include <vector>

#include "check/run/gates.h"
#include "eventually.h"
#include "shapes.h"

using namespace meshgauge;
using namespace meshgauge::check;

TEST_CASE("a mesh is read once for all gates and threads, by whatever way its file is named") {
  const Folder folder;
  const auto base = folder.obj("base.obj", shapes::grid(30));
  const auto other = folder.obj("other.obj", shapes::grid(3));
  std::filesystem::create_directory(folder.path() / "sub");
  const auto detour = folder.path() / "sub" / ".." / "base.obj";
  Meshes meshes({gate(other, base, 1), gate(other, detour, 1)});
  std::vector<api::SharedMesh> got(8);
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < got.size(); ++i) {
    threads.emplace_back([&, i] {
      Control control;
      got[i] = meshes.get(i % 2 ? base : detour, control).value();
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const auto& mesh : got) CHECK(mesh == got[0]);
  CHECK(got[0]->mesh.use() == Prepared::Use::often);
  CHECK(got[0]->facts.triangles == 2 * 30 * 30);
}

TEST_CASE("a glTF behind a link is another mesh, since it names files in its own folder") {
  const Folder folder;
  const auto base = folder.obj("base.gltf", shapes::grid(3));  // whatever it holds
  std::filesystem::create_directory(folder.path() / "sub");
  const auto link = folder.path() / "sub" / "base.gltf";
  std::filesystem::create_symlink(base, link);
  std::filesystem::create_directory_symlink(folder.path(), folder.path() / "same");
  const auto same = folder.path() / "same" / "base.gltf";
  Meshes meshes({gate(link, base, 1), gate(same, base, 1)});
  Control control;
  CHECK(meshes.get(base, control).value() != meshes.get(link, control).value());
  CHECK(meshes.get(base, control).value() == meshes.get(same, control).value());
}

TEST_CASE("when meshes are stopped nothing is read any more") {
  const Folder folder;
  const auto base = folder.obj("base.obj", shapes::grid(100));
  const auto other = folder.obj("other.obj", shapes::grid(3));
  Meshes meshes({gate(other, base, 1)});
  meshes.begin(base);
  meshes.stop();
  CHECK_FALSE(meshes.reading());
  Control control;
  CHECK(meshes.get(other, control).error().code == ErrorCode::out_of_time);
}

TEST_CASE("a mesh is freed after the last gate and turn that needs it") {
  const Folder folder;
  const auto base = folder.obj("base.obj", shapes::grid(3));
  const std::vector<Gate> gates{gate(folder.obj("1.obj", shapes::grid(4)), base, 1),
                                gate(folder.obj("2.obj", shapes::grid(5)), base, 1)};
  Meshes meshes(gates, 2);
  Control control;
  std::weak_ptr<const api::PreparedMesh> kept = meshes.get(base, control).value();
  std::weak_ptr<const api::PreparedMesh> first = meshes.get(gates[0].candidate, control).value();
  CHECK(first.lock()->mesh.use() == Prepared::Use::once);
  meshes.done(gates[0]);
  CHECK(!first.expired());
  meshes.done(gates[0]);
  // The thread that has read it may hold it for a moment longer.
  while (!first.expired()) std::this_thread::yield();
  meshes.done(gates[1]);
  CHECK(!kept.expired());
  meshes.done(gates[1]);
  while (!kept.expired()) std::this_thread::yield();
}

TEST_CASE("files that are removed and links that move during the run do not matter") {
  const Folder folder;
  const auto base = folder.obj("base.obj", shapes::grid(3));
  const auto part = folder.obj("part.obj", shapes::grid(4));
  const auto link = folder.path() / "link.obj";
  std::filesystem::create_symlink(base, link);
  const auto both = gate(part, link, 1);
  Meshes meshes({both});
  Control control;
  const auto first = meshes.get(link, control).value();
  CHECK(meshes.get(part, control).ok());
  std::filesystem::remove(link);
  std::filesystem::create_symlink(folder.obj("elsewhere.obj", shapes::grid(5)), link);
  std::filesystem::remove(part);
  CHECK(meshes.get(link, control).value() == first);
  CHECK(meshes.get(part, control).ok());
  meshes.done(both);
}

TEST_CASE("every caller gets the Error of an unreadable file") {
  const Folder folder;
  const auto good = folder.obj("good.obj", shapes::grid(2));
  const auto bad = folder.file("bad.obj", "v 0 0 0\nv 1 0 0\nv 0 nan 0\nf 1 2 3\n");
  const auto none = folder.path() / "none.obj";
  Meshes meshes({gate(good, bad, 1), gate(good, none, 1)});
  Control control;
  for (int i = 0; i < 2; ++i) {
    const auto damaged = meshes.get(bad, control);
    REQUIRE(!damaged);
    CHECK(damaged.error().message.find("line 3 of '" + bad.string() + "'") != std::string::npos);
    const auto missing = meshes.get(none, control);
    REQUIRE(!missing);
    CHECK(missing.error().message.find("none.obj' cannot be read: No such file") != std::string::npos);
  }
}

TEST_CASE("a cancelled or late caller does not wait for the reader") {
  const Folder folder;
  const auto file = folder.obj("a.obj", shapes::grid(300));  // not read within no time
  Meshes meshes({gate(file, file, 1)});
  Control cancelled;
  cancelled.cancel();
  const auto given_up = meshes.get(file, cancelled);
  if (!given_up) CHECK(given_up.error().code == ErrorCode::out_of_time);
  Control late(Control::Clock::now());
  const auto over = meshes.get(file, late);
  if (!over) CHECK(over.error().code == ErrorCode::out_of_time);
  CHECK((!given_up || !over));
  Control patient;
  CHECK(meshes.get(file, patient).ok());
}

TEST_CASE("readers without a waiting caller are counted until they end") {
  const Folder folder;
  const auto file = folder.obj("a.obj", shapes::grid(300));
  Meshes meshes({gate(file, file, 1)});
  CHECK(!meshes.reading());
  meshes.begin(file);
  CHECK(meshes.reading());  // 180,000 triangles
  Control control;
  CHECK(meshes.get(file, control).ok());
  while (meshes.reading()) std::this_thread::yield();
}

TEST_CASE("a further turn reads the files again that were freed") {
  const Folder folder;
  const std::vector<Gate> gates{gate(folder.obj("a.obj", shapes::grid(4)), folder.obj("b.obj", shapes::grid(5)), 1)};
  Meshes meshes(gates);
  Control control;
  std::weak_ptr<const api::PreparedMesh> first = meshes.get(gates[0].candidate, control).value();
  meshes.done(gates[0]);
  CHECK(eventually([&] { return first.expired(); }));
  meshes.again(gates[0]);
  const std::weak_ptr<const api::PreparedMesh> second = meshes.get(gates[0].candidate, control).value();
  CHECK_FALSE(second.expired());
  meshes.done(gates[0]);
  CHECK(eventually([&] { return second.expired(); }));
}
