#include "check/run/meshes.h"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <new>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>

#include "api/formats/detect.h"
#include "api/load.h"
#include "check/mesh_file.h"

namespace meshgauge::check {
namespace {

constexpr std::chrono::milliseconds kTick{10};

// Two ways to the same file are one mesh. The name stays part of it: its suffix may decide what the bytes are read as.
// So does the folder of a glTF, which may name files there.
std::string key_of(const std::filesystem::path& file) {
  std::error_code failed;
  const bool has_folder = api::format_by_name(file.string()) == api::Format::gltf;
  const auto real = std::filesystem::canonical(has_folder ? folder_of(file) : file, failed);
  return (failed ? file : real).string() + '\n' + file.filename().string();
}

Result<Meshes::Mesh> read(const std::string& name, Prepared::Use use) try {
  const auto file = MeshFile::open(name);
  if (!file) return file.error();
  Control unlimited;
  auto loaded = api::load({name, file->bytes(), name, ""}, api::ReadLimits{}, unlimited);
  if (!loaded) return std::move(loaded).error();
  return std::make_shared<const api::PreparedMesh>(std::move(*loaded), file->bytes().size(), use);
} catch (const std::bad_alloc&) {
  return Error{ErrorCode::internal, "not enough memory to read '" + name + "'", "", ""};
} catch (const std::exception& error) {
  return Error{ErrorCode::internal, "'" + name + "' could not be read: " + error.what(), "", ""};
}

}  // namespace

struct Meshes::File {
  std::mutex mutex;
  std::condition_variable changed;
  std::optional<Result<Mesh>> mesh;  // none: being read

  void set(Result<Mesh> result) {
    const std::lock_guard lock(mutex);
    mesh = std::move(result);
    changed.notify_all();
  }
};

Meshes::Meshes(const std::vector<Gate>& gates, unsigned turns) {
  for (const Gate& gate : gates) {
    for (const auto& file : {gate.candidate, gate.baseline}) {
      Entry*& entry = of_file_[file];
      if (!entry) entry = &entries_[key_of(file)];
      entry->uses += turns;
    }
  }
  for (auto& [key, entry] : entries_) entry.use = entry.uses > turns ? Prepared::Use::often : Prepared::Use::once;
}

void Meshes::begin(const std::filesystem::path& file) { (void)begun(file); }

std::shared_ptr<Meshes::File> Meshes::begun(const std::filesystem::path& file) {
  const std::lock_guard lock(mutex_);
  Entry& entry = *of_file_.at(file);
  if (entry.file) return entry.file;
  entry.file = std::make_shared<File>();
  const auto work = [waited_for = entry.file, name = file.string(), use = entry.use, readers = readers_]() mutable {
    waited_for->set(read(name, use));
    waited_for.reset();  // nobody else may have waited, then the mesh is freed here
    --*readers;
  };
  ++*readers_;
  try {
    std::thread(work).detach();
  } catch (const std::system_error&) {  // no more threads: then here, and nobody can give up
    auto here = work;
    here();
  }
  return entry.file;
}

Result<Meshes::Mesh> Meshes::get(const std::filesystem::path& file, Control& control) {
  const auto reading = begun(file);
  std::unique_lock lock(reading->mutex);
  while (!reading->mesh) {
    if (const auto why = control.check(); why != Interruption::none) {
      return api::not_in_time(why, "'" + file.string() + "' was read");
    }
    reading->changed.wait_for(lock, kTick);
  }
  return *reading->mesh;
}

void Meshes::done(const Gate& gate) noexcept {
  for (const auto* file : {&gate.candidate, &gate.baseline}) {
    std::shared_ptr<File> last;  // its mesh is freed without the lock
    const std::lock_guard lock(mutex_);
    const auto entry = of_file_.find(*file);
    if (entry != of_file_.end() && --entry->second->uses == 0) last = std::move(entry->second->file);
  }
}

}  // namespace meshgauge::check
