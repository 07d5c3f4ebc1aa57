#include "tests/api/formats/zip_files.h"

#include <stdexcept>

#include <zlib.h>

#include "tests/api/formats/files.h"

namespace meshgauge::api::test {
namespace {

constexpr int kRaw = -15;
constexpr int kGzip = 15 + 16;

std::string deflated(std::string_view content, int window_bits) {
  z_stream stream{};
  if (deflateInit2(&stream, 6, Z_DEFLATED, window_bits, 8, Z_DEFAULT_STRATEGY) != Z_OK)
    throw std::runtime_error("zlib");
  std::string out(deflateBound(&stream, content.size()) + 32, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(content.data()));
  stream.avail_in = static_cast<uInt>(content.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  if (deflate(&stream, Z_FINISH) != Z_STREAM_END) throw std::runtime_error("zlib");
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

std::string raw16(std::size_t value) { return raw(static_cast<std::uint16_t>(value)); }
std::string raw32(std::size_t value) { return raw(static_cast<std::uint32_t>(value)); }

// The fields shared by the header of an entry and the directory, from the version to the length of the extra field.
std::string fields(const ZipEntry& entry, std::size_t packed_bytes, std::size_t extra_bytes) {
  const auto crc =
      crc32(0, reinterpret_cast<const Bytef*>(entry.content.data()), static_cast<uInt>(entry.content.size()));
  const std::string sizes = entry.in_zip64 ? raw32(0xFFFFFFFF) + raw32(0xFFFFFFFF)
                                           : raw32(packed_bytes) + raw32(entry.content.size() + entry.size_lie);
  return raw16(20) + raw16(entry.flags) + raw16(entry.method) + raw32(0) + raw32(crc + entry.crc_lie) + sizes +
         raw16(entry.name.size()) + raw16(extra_bytes);
}

// Empty for a plain entry. The times around the Zip64 field are numbers that would lead far away if they were taken for
// fields.
std::string extra_fields(const ZipEntry& entry, std::size_t packed_bytes, std::size_t offset) {
  if (!entry.in_zip64) return "";
  const std::string time = "UT" + raw16(5) + "\x03\xFF\xFF\xFF\x7F";
  return time + raw16(1) + raw16(24) + raw(std::uint64_t{entry.content.size() + entry.size_lie + entry.size_lie_64}) +
         raw(std::uint64_t{packed_bytes}) + raw(std::uint64_t{offset}) + time;
}

struct Parts {
  std::string entries;
  std::string directory;
};

Parts parts_of(const std::vector<ZipEntry>& entries) {
  Parts out;
  for (const ZipEntry& entry : entries) {
    const std::string packed = entry.method == 0 ? entry.content : deflated(entry.content, kRaw);
    const std::size_t offset = out.entries.size();
    const std::string extra = extra_fields(entry, packed.size(), offset);
    const std::string both = fields(entry, packed.size(), extra.size());
    out.directory += "PK\x01\x02" + raw16(20) + both + raw16(0) + raw16(0) + raw16(0) + raw32(0) +
                     raw32(entry.in_zip64 ? 0xFFFFFFFF : offset) + entry.name + extra;
    out.entries += "PK\x03\x04" + both + entry.name + extra + packed;
  }
  return out;
}

std::string end_record(std::size_t count, std::size_t bytes, std::size_t offset, const std::string& comment) {
  return "PK\x05\x06" + raw16(0) + raw16(0) + raw16(count) + raw16(count) + raw32(bytes) + raw32(offset) +
         raw16(comment.size()) + comment;
}

}  // namespace

std::string gzipped(std::string_view content) { return deflated(content, kGzip); }

std::string zip(const std::vector<ZipEntry>& entries, const std::string& comment) {
  const Parts parts = parts_of(entries);
  return parts.entries + parts.directory +
         end_record(entries.size(), parts.directory.size(), parts.entries.size(), comment);
}

std::string zip64(const std::vector<ZipEntry>& entries, std::uint64_t count) {
  const Parts parts = parts_of(entries);
  const std::string record = "PK\x06\x06" + raw(std::uint64_t{44}) + raw16(45) + raw16(45) + raw32(0) + raw32(0) +
                             raw(count) + raw(count) + raw(std::uint64_t{parts.directory.size()}) +
                             raw(std::uint64_t{parts.entries.size()});
  const std::string locator =
      "PK\x06\x07" + raw32(0) + raw(std::uint64_t{parts.entries.size() + parts.directory.size()}) + raw32(1);
  return parts.entries + parts.directory + record + locator + end_record(0xFFFF, 0xFFFFFFFF, 0xFFFFFFFF, "");
}

std::string relationships(const std::string& target) {
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
         "<Relationships xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\">"
         "<Relationship Type=\"http://schemas.openxmlformats.org/package/2006/relationships/metadata/thumbnail\" "
         "Target=\"/Metadata/thumbnail.png\" Id=\"rel1\"/>"
         "<Relationship Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\" Target=\"" +
         target + "\" Id=\"rel0\"/></Relationships>";
}

std::string model(const std::string& resources, const std::string& build, const std::string& attributes) {
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
         "<model xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\" " +
         attributes + ">\n<metadata name=\"Title\">a &lt;test&gt;</metadata>\n<resources>" + resources +
         "</resources>\n<build>" + build + "</build>\n</model>\n";
}

std::string triangle_object(int id) {
  return "<object id=\"" + std::to_string(id) +
         "\" type=\"model\"><mesh><vertices><vertex x=\"0\" y=\"0\" z=\"0\"/><vertex x=\"1\" y=\"0\" z=\"0\"/>"
         "<vertex x=\"0\" y=\"1\" z=\"0\"/></vertices><triangles><triangle v1=\"0\" v2=\"1\" v3=\"2\"/></triangles>"
         "</mesh></object>";
}

std::string package(const std::string& model, std::vector<ZipEntry> more) {
  more.insert(more.begin(),
              {{"[Content_Types].xml", "<Types/>"}, {"_rels/.rels", relationships()}, {"3D/3dmodel.model", model}});
  return zip(more);
}

}  // namespace meshgauge::api::test
