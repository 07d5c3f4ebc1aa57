// How the statically linked program looks up hosts and users.
#pragma once

namespace meshgauge::cli {

// Looks hosts up in /etc/hosts and by DNS, users in /etc/passwd, whatever /etc/nsswitch.conf says. glibc would load
// what is named there as shared libraries, which fit no static program but one of the machine's own glibc. Call it
// before any lookup. No effect on a program with shared libraries.
void use_built_in_name_services();

}  // namespace meshgauge::cli
