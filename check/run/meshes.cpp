#include "check/run/meshes.h"

#include <atomic>
#include <chrono>
#include <memory>
#include <new>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "api/base/byte_budget.h"
#include "api/compare/load.h"
#include "api/compare/mesh_file.h"
#include "api/formats/detect.h"

namespace meshgauge::check {
namespace {

constexpr std::chrono::milliseconds kMeshTick{10};

// Two paths to one file are one mesh; what `copies` names is never another file of that name. The file's name is part
// of the key, since its suffix may decide the format, and for a .gltf the folder, which holds its other files.
std::string key_of(const std::filesystem::path& file, const api::Copies* copies) {
  std::error_code failed;
  const auto copy = copies ? copies->find(file.string()) : api::Copies::const_iterator{};
  const auto place = copies && copy != copies->end() ? std::filesystem::path(copy->second) : file;
  const bool has_folder = api::format_by_name(file.string()) == api::Format::gltf;
  const auto real = std::filesystem::canonical(has_folder ? api::folder_of(place) : place, failed);
  return (failed ? file : real).string() + '\n' + file.filename().string();
}

// What a gate says of its files.
struct Sources {
  std::shared_ptr<const api::Pipes> pipes;
  std::shared_ptr<const api::Copies> copies;
  std::shared_ptr<const api::Confines> confines;
};

// Arrays of a mesh, and what its file takes of a budget as long as they are there.
struct Kept {
  std::shared_ptr<const void> arrays;
  std::vector<api::ByteBudget::Lease> leases;
};

Result<api::MeshFile> opened(const std::string& name, const Sources& sources) {
  if (!sources.confines) return api::MeshFile::open(name, sources.pipes.get(), sources.copies.get());
  std::error_code failed;
  return api::MeshFile::open_within(*sources.confines, std::filesystem::absolute(name, failed).string());
}

Result<api::SharedMesh> read(const std::string& name, const Sources& sources, Prepared::Use use,
                             const std::atomic<bool>& stopped) try {
  const auto cancelled = [&] { return api::not_in_time(Interruption::cancelled, "'" + name + "' was read"); };
  if (stopped) return cancelled();
  const auto file = opened(name, sources);
  if (!file) return file.error();
  if (stopped) return cancelled();
  const api::ReadLimits limits = sources.confines ? sources.confines->limits : api::ReadLimits{};
  auto loaded = api::load({name, file->bytes(), name, ""}, limits);
  if (!loaded) return std::move(loaded).error();
  loaded->arrays = std::make_shared<const Kept>(Kept{std::move(loaded->arrays), file->leases()});
  return std::make_shared<const api::PreparedMesh>(std::move(*loaded), file->bytes().size(), use);
} catch (const std::bad_alloc&) {
  return Error{ErrorCode::internal, "not enough memory to read '" + name + "'", "", ""};
} catch (const std::exception& error) {
  return Error{ErrorCode::internal, "'" + name + "' could not be read: " + error.what(), "", ""};
}

}  // namespace

Meshes::Meshes(const std::vector<Gate>& gates, unsigned turns) {
  for (const Gate& gate : gates) {
    for (const auto& file : {gate.candidate, gate.baseline}) {
      Entry*& entry = of_file_[file];
      if (!entry) entry = &entries_[key_of(file, gate.copies.get())];
      entry->uses += turns;
      entry->pipes = gate.pipes;
      entry->copies = gate.copies;
      entry->confines = gate.confines;
    }
  }
  for (auto& [key, entry] : entries_) entry.use = entry.uses > turns ? Prepared::Use::often : Prepared::Use::once;
}

void Meshes::begin(const std::filesystem::path& file) { (void)begun(file); }

Meshes::File Meshes::begun(const std::filesystem::path& file) {
  const std::lock_guard lock(mutex_);
  Entry& entry = *of_file_.at(file);
  if (entry.file.valid()) return entry.file;
  auto reading = std::make_shared<std::packaged_task<Result<api::SharedMesh>()>>(
      [name = file.string(), sources = Sources{entry.pipes, entry.copies, entry.confines}, use = entry.use,
       readers = readers_] { return read(name, sources, use, readers->stopped); });
  entry.file = reading->get_future().share();
  const auto work = [reading = std::move(reading), readers = readers_]() mutable {
    (*reading)();
    reading.reset();  // frees the mesh here if no thread waits for it
    --readers->running;
    readers->running.notify_all();
  };
  ++readers_->running;
  try {
    std::thread(work).detach();
  } catch (const std::system_error&) {  // no thread to be had: read here; a waiting thread cannot give up then
    auto here = work;
    here();
  }
  return entry.file;
}

Result<api::SharedMesh> Meshes::get(const std::filesystem::path& file, Control& control) {
  const File reading = begun(file);
  while (reading.wait_for(kMeshTick) != std::future_status::ready) {
    if (const auto why = control.check(); why != Interruption::none) {
      return api::not_in_time(why, "'" + file.string() + "' was read");
    }
  }
  return reading.get();
}

void Meshes::stop() {
  readers_->stopped = true;
  for (int running = readers_->running; running > 0; running = readers_->running) readers_->running.wait(running);
}

void Meshes::done(const Gate& gate) noexcept {
  for (const auto* file : {&gate.candidate, &gate.baseline}) {
    File last;  // freed after the lock is released
    const std::lock_guard lock(mutex_);
    const auto entry = of_file_.find(*file);
    if (entry != of_file_.end() && --entry->second->uses == 0) last = std::move(entry->second->file);
  }
}

void Meshes::again(const Gate& gate) {
  const std::lock_guard lock(mutex_);
  for (const auto* file : {&gate.candidate, &gate.baseline}) ++of_file_.at(*file)->uses;
}

}  // namespace meshgauge::check
