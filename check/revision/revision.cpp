#include "check/revision/revision.h"

#include <stdlib.h>
#include <sys/types.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <span>
#include <string_view>
#include <system_error>
#include <utility>

#include "api/base/digest.h"
#include "api/base/json_filter.h"
#include "api/base/refused.h"
#include "api/base/text.h"
#include "api/base/utf8.h"
#include "api/base/whole_file.h"
#include "api/formats/detect.h"
#include "api/formats/gltf/gltf_bundle.h"
#include "check/files.h"
#include "check/manifest/glob.h"
#include "check/manifest/spelling.h"
#include "check/revision/templates.h"

namespace meshgauge::check {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kSubmodule = "160000", kSymbolicLink = "120000";  // modes of git's trees
constexpr std::size_t kMostPointerBytes = 1024;                              // as Git LFS has it
constexpr std::size_t kMostMissing = 100;                             // files of a partial clone: each costs a git
constexpr std::size_t kPeekedBytes = 4096;                            // which tell a glTF from other files
constexpr std::uint64_t kMostCopiedBytes = std::uint64_t{64} << 30U;  // of all copies together

Error bad_revision(const std::string& why) { return bad_flag("--against", why); }

// The lines of git's output; `end` ends each.
class Lines {
 public:
  explicit Lines(std::FILE* file) : file_(file) {}
  ~Lines() { std::free(line_); }
  Lines(const Lines&) = delete;
  Lines& operator=(const Lines&) = delete;

  // Reads the next line, without its end; false: there is none. `line` is valid until the next call.
  bool next(std::string_view& line, char end) {
    const ssize_t length = ::getdelim(&line_, &room_, static_cast<unsigned char>(end), file_);
    if (length <= 0) return false;
    line = std::string_view(line_, static_cast<std::size_t>(length));
    if (line.ends_with(end)) line.remove_suffix(1);
    return true;
  }

 private:
  std::FILE* file_;
  char* line_ = nullptr;
  std::size_t room_ = 0;
};

struct FileClosed {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using OpenFile = std::unique_ptr<std::FILE, FileClosed>;

enum class Copied { whole, nowhere, no_room, cut };

// Copies so many bytes to a new file. nowhere: there can be no such file, and the bytes are passed over. cut: `from`
// has fewer. `sha256`: takes what is read.
Copied copy_bytes(std::FILE* from, std::uint64_t count, const fs::path& place, api::Sha256* sha256 = nullptr) {
  std::error_code failed;
  fs::create_directories(place.parent_path(), failed);
  OpenFile to(std::fopen(place.c_str(), "wbxe"));
  std::array<std::byte, 1 << 16> piece{};
  while (count > 0) {
    const auto most = static_cast<std::size_t>(std::min<std::uint64_t>(count, piece.size()));
    const std::size_t read = std::fread(piece.data(), 1, most, from);
    if (read == 0) return Copied::cut;
    if (sha256) sha256->update(std::span(piece).first(read));
    if (to && std::fwrite(piece.data(), 1, read, to.get()) != read) return Copied::no_room;
    count -= read;
  }
  if (!to) return Copied::nowhere;
  return std::fclose(to.release()) == 0 ? Copied::whole : Copied::no_room;
}

// Whether the bytes at the beginning of the file are those of a glTF.
bool is_gltf(const fs::path& file) {
  const OpenFile in(std::fopen(file.c_str(), "rbe"));
  std::array<std::byte, kPeekedBytes> piece{};
  return in && api::is_gltf_json(std::span(piece).first(std::fread(piece.data(), 1, piece.size(), in.get())));
}

// The digest in the pointer of Git LFS; empty: the text is none.
std::string digest_of_pointer(std::string_view text) {
  constexpr std::string_view kVersion = "version https://git-lfs.github.com/spec/", kObject = "\noid sha256:";
  const std::size_t at = text.find(kObject);
  if (!text.starts_with(kVersion) || at == std::string_view::npos) return "";
  const std::string_view digest = text.substr(at + kObject.size(), 64);
  return api::is_lower_hex(digest, 64) ? std::string(digest) : "";
}

// The names of the files that a glTF needs beside it; none of another file.
std::vector<std::string> companions_of(const fs::path& file) {
  if (!is_gltf(file)) return {};
  const auto whole = api::WholeFile::open(file.string());
  if (!whole) return {};
  std::vector<std::string> names = api::files_named_by(whole->bytes());
  std::erase_if(names, [&](const std::string& name) {
    return name.empty() || api::is_scene_path(name) || name == file.filename().string();
  });
  if (names.size() > api::kMostBundleFiles) names.clear();  // refused where it is read
  return names;
}

// Whether the path is one of `paths`, or on the way to one.
bool leads_to(const std::set<std::string>& paths, const std::string& path) {
  const auto below = paths.lower_bound(path + "/");
  return paths.contains(path) || (below != paths.end() && below->starts_with(path + "/"));
}

// A path as a name of a gate: what is no character, or controls a terminal, as %XX.
std::string in_plain_characters(const std::string& path) {
  if (is_utf8(path) && find_control(path) == std::string::npos) return path;
  std::string out;
  for (const char c : path) {
    constexpr const char* kDigits = "0123456789ABCDEF";
    const auto byte = static_cast<unsigned char>(c);
    const bool plain = byte >= 0x20 && byte < 0x7F;
    out += plain ? std::string(1, c) : std::string{'%', kDigits[byte / 16], kDigits[byte % 16]};
  }
  return out;
}

// In a container of CI the work tree is another user's: git's own remedy stands some lines below its message.
std::string remedied(const std::string& message) {
  if (message.find("dubious ownership") == std::string::npos) return message;
  return message + "; trust it by 'git config --global --add safe.directory \"$PWD\"' in its folder";
}

void add_defect(Gate& gate, const std::string& what) {
  gate.defects.push_back({gate.line, gate.line > 0 ? 1 : 0, "the baseline " + shown_path(gate.baseline) + " " + what});
}

}  // namespace

Revision::Folder::~Folder() {
  std::error_code none;
  if (!path.empty()) fs::remove_all(path, none);
}

Result<Revision> Revision::open(const std::string& ref, const fs::path& folder, const Interrupted& interrupted) {
  if (ref.empty()) return bad_revision("is empty: name a revision, as in --against main");
  // So it is no option: --end-of-options is not known to git before 2.30.
  if (ref.front() == '-') return bad_revision(api::shown_text(ref) + " begins with '-', as no name of a revision does");
  const fs::path start = folder.empty() ? fs::path(".") : folder;
  Git git(start, interrupted);
  const auto top = git.output({"rev-parse", "--show-toplevel"});
  if (!top)
    return bad_revision("needs the git repository of " + shown_path(start) + ": " + remedied(top.error().message));
  const auto commit = git.output({"rev-parse", "--verify", ref + "^{commit}"});
  if (!commit)
    return bad_revision("there is no commit " + api::shown_text(ref) + " in the repository " + shown_path(*top) +
                        ": fetch it, as by 'fetch-depth: 0' of actions/checkout; a branch that only the server has is "
                        "'origin/NAME'");
  Revision revision(std::move(git), {ref, *commit});
  std::error_code failed;
  revision.top_ = fs::weakly_canonical(*top, failed);
  const auto common = revision.git_.output({"rev-parse", "--git-common-dir"});
  if (!common) return bad_revision(common.error().message);
  const fs::path store = fs::absolute(start, failed) / *common;
  const auto named = revision.git_.output({"config", "--get", "lfs.storage"});
  revision.lfs_ = store / (named && !named->empty() ? *named : "lfs");
  return revision;
}

Result<Done> Revision::list_tree(const Visit& visit) const {
  return git_.run({"ls-tree", "-r", "-z", "--full-tree", name_.commit}, "", [&](std::FILE* out) {
    Lines lines(out);
    for (std::string_view line; lines.next(line, '\0');) {
      constexpr auto kNone = std::string_view::npos;  // "MODE TYPE OBJECT<tab>PATH"
      const std::size_t mode = line.find(' '), type = line.find(' ', mode + 1), tab = line.find('\t');
      if (mode == kNone || type == kNone || tab == kNone) return false;
      visit(std::string(line.substr(tab + 1)), line.substr(0, mode), line.substr(type + 1, tab - type - 1));
    }
    return true;
  });
}

// A file that is here as well was not renamed.
Result<Done> Revision::read_tree(const std::set<std::string>& paths) {
  const Utf8Locale utf8;
  std::set<std::string> names;
  for (const std::string& path : paths) names.insert(spelling_key(name_in_folder(path)));
  return list_tree([&](const std::string& path, std::string_view mode, std::string_view object) {
    if (leads_to(paths, path)) tree_[path] = {std::string(mode), std::string(object)};
    const std::string name = spelling_key(name_in_folder(path));
    if (!names.contains(name) || namesakes_[name].size() > 1) return;
    std::error_code failed;
    if (!fs::exists(fs::symlink_status(top_ / path, failed))) namesakes_[name].insert(path);
  });
}

Result<std::vector<Gate>> Revision::without_candidate(const std::vector<OpenBaselines>& open,
                                                      const std::set<std::string>& paths) const {
  std::vector<Gate> gates;
  if (open.empty()) return gates;
  const auto lost = [&](const OpenBaselines& of, const std::string& path) {
    Gate gate = of.gate;
    gate.baseline = name_.ref + ":" + path;
    gate.name = name_.ref + ":" + in_plain_characters(path);
    return gate;
  };
  const Utf8Locale utf8;
  Templates templates;
  std::set<std::string> names;
  for (const OpenBaselines& of : open) {
    const auto within = path_of(of.folder / fixed_folder(of.pattern) / "*");
    if (within) {
      templates.add(of, folder_in_repository(*within));
    } else if (Gate gate = lost(of, of.pattern); names.insert(gate.name).second) {
      add_defect(gate, within.error().message);
      gates.push_back(std::move(gate));
    }
  }
  const auto done = list_tree([&](const std::string& path, std::string_view mode, std::string_view) {
    if (gates.size() > kMaxGates || mode == kSubmodule || paths.contains(path)) return;
    const OpenBaselines* of = templates.matching(path);
    if (!of) return;
    Gate gate = lost(*of, path);
    while (!names.insert(gate.name).second) gate.name += '%';
    add_defect(gate, of->lack + "; if it is gone on purpose, the error ends with a revision that lacks it too, and " +
                         "'unmatched_baselines: ignore' accepts all that are gone");
    gates.push_back(std::move(gate));
  });
  if (!done) return bad_revision(done.error().message);
  return gates;
}

Result<Done> Revision::make_folder() {
  std::error_code failed;
  std::string name = (fs::temp_directory_path(failed) / "meshgauge-against-XXXXXX").string();
  if (failed || !::mkdtemp(name.data()))
    return bad_revision("there is no folder for temporary files: set the variable TMPDIR");
  folder_ = std::make_unique<Folder>();
  folder_->path = name;
  return Done{};
}

// Links of the work tree are not followed, since its author may have put them in the place of what the revision has.
Result<std::string> Revision::path_of(const fs::path& baseline) const {
  std::error_code failed;
  const fs::path whole = fs::absolute(baseline, failed).lexically_normal();
  fs::path above;  // the outermost folder that is in the work tree, however it is called
  for (const fs::path& part : whole) {
    above /= part;
    if (failed || above == whole) break;
    const fs::path real = fs::weakly_canonical(above, failed);
    if (failed || !is_below(real, top_)) continue;
    const fs::path path = (real / whole.lexically_relative(above)).lexically_relative(top_);
    return path.lexically_normal().generic_string();
  }
  return refused("is outside of the repository " + shown_path(top_) + ", from which --against reads");
}

Result<std::string> Revision::object_of(const std::string& path) const {
  for (std::size_t slash = path.find('/'); slash != std::string::npos; slash = path.find('/', slash + 1)) {
    const auto above = tree_.find(path.substr(0, slash));
    const std::string mode = above == tree_.end() ? "" : above->second.mode;
    if (mode == kSubmodule)
      return refused("lies in the submodule " + shown_path(above->first) + ", whose files " + name_.in_words() +
                     " does not hold: check it by a manifest in the submodule");
    if (mode == kSymbolicLink)
      return refused("lies behind the symbolic link " + shown_path(above->first) + " of " + name_.in_words() +
                     ", which is not followed: name the file itself");
  }
  const auto found = tree_.find(path);
  if (found == tree_.end()) return refused("is not in " + name_.in_words() + elsewhere(path));
  if (found->second.mode == kSubmodule) return refused("is a submodule in " + name_.in_words());
  if (found->second.mode == kSymbolicLink)
    return refused("is a symbolic link in " + name_.in_words() + ", which is not followed: name the file itself");
  return found->second.object;
}

// Where a file of the same name was, if there is one.
std::string Revision::elsewhere(const std::string& path) const {
  const Utf8Locale utf8;
  const auto same = namesakes_.find(spelling_key(name_in_folder(path)));
  if (same == namesakes_.end() || same->second.size() != 1) return ": it is new, or had another name there";
  return ": there it is " + shown_path(*same->second.begin());
}

void Revision::find_object(Copy& copy) const {
  const auto object = object_of(copy.path);
  (object ? copy.object : copy.defect) = object ? *object : object.error().message;
}

void Revision::add_copy(const std::string& path) {
  const auto [copy, is_new] = copies_.try_emplace(path);
  if (!is_new) return;
  copy->second.path = path;
  copy->second.place = folder_->path / std::to_string(copies_.size()) / name_in_folder(path);
  find_object(copy->second);
}

// In a partial clone git ends at the first file whose content is not there.
Result<Done> Revision::fetch(const Needed& needed) {
  std::size_t missing = 0;
  for (std::size_t read = 0; read < needed.size();) {
    std::string trouble;
    const auto done = fetch(std::span(needed).subspan(read), read, trouble);
    if (!trouble.empty()) return bad_revision("the files of " + name_.in_words() + " " + trouble);
    if (done) continue;
    if (read == needed.size() || done.error().message.find("promisor") == std::string::npos)
      return bad_revision(done.error().message);
    if (++missing > kMostMissing)
      return bad_revision("many files of " + name_.in_words() +
                          " are not in this partial clone: clone without '--filter'");
    Copy& copy = *needed[read++];
    copy.defect = "cannot be read: its content is not in this partial clone; fetch it by 'git cat-file -e " +
                  copy.object + "', or clone without '--filter'";
  }
  return Done{};
}

Result<Done> Revision::fetch(std::span<Copy* const> needed, std::size_t& read, std::string& trouble) {
  std::string asked;
  for (const Copy* copy : needed) asked += copy->object + "\n";
  return git_.run({"cat-file", "--batch"}, asked, [&](std::FILE* out) {
    Lines lines(out);
    for (Copy* copy : needed) {
      std::string_view line;  // "OBJECT blob SIZE" or "OBJECT missing"
      if (!lines.next(line, '\n')) return false;
      if (line.ends_with(" missing")) {
        copy->defect = "cannot be read: the repository lacks its content; fetch " + name_.in_words() + " as a whole";
        ++read;
        continue;
      }
      std::int64_t bytes = -1;
      const std::size_t space = line.rfind(' ');
      api::parse_integer(line.data() + space + 1, line.data() + line.size(), bytes);
      if (space == std::string_view::npos || bytes < 0) return false;
      if (!take(*copy, out, static_cast<std::uint64_t>(bytes), trouble) || std::fgetc(out) != '\n') return false;
      if (copy->defect.empty()) resolve_pointer(*copy);
      ++read;
    }
    return true;
  });
}

bool Revision::take(Copy& copy, std::FILE* from, std::uint64_t bytes, std::string& trouble) {
  copied_bytes_ += bytes;
  if (copied_bytes_ > kMostCopiedBytes) {
    trouble = "are larger than 64 GiB together: check them by several manifests";
    return false;
  }
  const Copied copied = copy_bytes(from, bytes, copy.place);
  if (copied == Copied::no_room) trouble = "cannot be copied to " + shown_path(folder_->path) + ": is there room?";
  if (copied == Copied::nowhere) copy.defect = "cannot be copied: its name is no file's name here";
  return copied == Copied::whole || copied == Copied::nowhere;
}

// Replaces the pointer of Git LFS by its content.
void Revision::resolve_pointer(Copy& copy) const {
  const auto text = api::read_text_file(copy.place.string(), kMostPointerBytes);
  const std::string digest = text ? digest_of_pointer(*text) : "";
  if (digest.empty()) return;
  const fs::path object = lfs_ / "objects" / digest.substr(0, 2) / digest.substr(2, 2) / digest;
  std::error_code failed;
  const bool is_here = fs::is_regular_file(object, failed);
  const OpenFile from(is_here ? std::fopen(object.c_str(), "rbe") : nullptr);
  const std::uint64_t bytes = is_here ? fs::file_size(object, failed) : 0;
  if (!from || failed) {
    copy.defect = std::string(api::kLfsPointer) + " in " + name_.in_words() +
                  ", and its content is not here: fetch it by 'git lfs fetch' with the name of the remote and of the "
                  "revision";
    return;
  }
  fs::remove(copy.place, failed);
  api::Sha256 sha256;
  if (copy_bytes(from.get(), bytes, copy.place, &sha256) != Copied::whole)
    copy.defect = "cannot be copied from the store of Git LFS: is there room in " + shown_path(folder_->path) + "?";
  else if (sha256.hex() != digest)
    copy.defect = "has another content in the store of Git LFS than its pointer says: run 'git lfs fsck'";
}

// Copies the files that glTF files name beside them.
Result<Done> Revision::fetch_companions() {
  std::deque<Copy> companions;
  std::vector<std::pair<Copy*, std::string>> named;  // the file and its name of each companion
  std::set<std::string> paths;
  for (auto& [path, copy] : copies_) {
    if (!copy.defect.empty()) continue;
    for (const std::string& name : companions_of(copy.place)) {
      Copy& companion = companions.emplace_back();
      companion.path = folder_in_repository(path) + name;
      companion.place = copy.place.parent_path() / name;
      paths.insert(companion.path);
      named.emplace_back(&copy, name);
    }
  }
  if (companions.empty()) return Done{};
  if (auto ok = read_tree(paths); !ok) return bad_revision(ok.error().message);
  Needed needed;
  for (Copy& companion : companions) {
    find_object(companion);
    if (companion.defect.empty()) needed.push_back(&companion);
  }
  if (auto ok = fetch(needed); !ok) return ok;
  for (std::size_t i = 0; i < companions.size(); ++i) {
    auto& [copy, name] = named[i];
    if (copy->defect.empty() && !companions[i].defect.empty())
      copy->defect = "needs " + shown_path(name) + " beside it, which " + companions[i].defect;
  }
  return Done{};
}

Result<Done> Revision::take_baselines(std::vector<Gate>& gates, const std::vector<OpenBaselines>& open) {
  std::vector<std::string> paths;  // of the gates; empty: it has none
  for (Gate& gate : gates) {
    const auto path = path_of(gate.baseline);
    paths.push_back(path ? *path : "");
    if (!path) add_defect(gate, path.error().message);
  }
  const std::set<std::string> of_gates(paths.begin(), paths.end());
  if (auto ok = read_tree(of_gates); !ok) return bad_revision(ok.error().message);
  auto lost = without_candidate(open, of_gates);
  if (!lost) return lost.error();
  if (gates.size() + lost->size() > kMaxGates)
    return bad_revision("too many files of " + name_.in_words() + " have no candidate: more than " +
                        std::to_string(kMaxGates) +
                        " gates with them: split the manifest, or write 'unmatched_baselines: ignore'");
  if (auto ok = make_folder(); !ok) return ok;
  for (const std::string& path : paths) {
    if (!path.empty()) add_copy(path);
  }
  Needed needed;
  for (auto& [path, copy] : copies_) {
    if (copy.defect.empty()) needed.push_back(&copy);
  }
  if (auto ok = fetch(needed); !ok) return ok;
  if (auto ok = fetch_companions(); !ok) return ok;
  const auto name_of = [&](const std::string& path) { return name_.ref + ":" + path; };
  const auto places = std::make_shared<api::Copies>();
  for (const auto& [path, copy] : copies_) places->emplace(name_of(path), copy.place.string());
  for (std::size_t i = 0; i < gates.size(); ++i) {
    // A file may have the name of a copy, which stands in its place.
    if (places->contains(gates[i].candidate.string())) gates[i].candidate = "." / gates[i].candidate;
    if (paths[i].empty()) continue;
    gates[i].baseline = name_of(paths[i]);
    gates[i].copies = places;
    if (const Copy& copy = copies_.at(paths[i]); !copy.defect.empty()) add_defect(gates[i], copy.defect);
  }
  for (Gate& gate : *lost) {
    gate.copies = places;
    gates.push_back(std::move(gate));
  }
  return Done{};
}

void Revision::remove_copies() { folder_.reset(); }

}  // namespace meshgauge::check
