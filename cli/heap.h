// The heap of a process that measures and ends.
#pragma once

namespace meshgauge::cli {

// From now on blocks of up to 4 MiB that fit nowhere else come from huge pages: the first touch of small pages takes a
// tenth of a pair of some thousand triangles, and more where little is computed. For the first thread; a service keeps
// its heap small instead (server/base/heap.h). Does nothing without glibc.
void use_huge_pages();

}  // namespace meshgauge::cli
