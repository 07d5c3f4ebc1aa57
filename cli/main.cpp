// The program. With MESHGAUGE_STATIC it is linked without shared libraries, which changes what glibc and OpenSSL look
// up.
#ifdef MESHGAUGE_STATIC
#include <nss.h>
#include <openssl/crypto.h>

#include <initializer_list>
#endif

#include "cli/commands.h"
#include "cli/run.h"

#ifdef MESHGAUGE_STATIC
namespace {

// Keeps OpenSSL from reading openssl.cnf: providers that it names are shared libraries, which crash a static program
// whose glibc is not the machine's. Runs before all static objects, of which cpp-httplib has one that starts OpenSSL.
[[gnu::constructor(101)]] void read_no_openssl_config() { OPENSSL_init_crypto(OPENSSL_INIT_NO_LOAD_CONFIG, nullptr); }

// Looks hosts up in /etc/hosts and by DNS, users in /etc/passwd, whatever /etc/nsswitch.conf says. glibc would load
// what is named there as shared libraries, which fit no static program but one of the machine's own glibc. Call it
// before any lookup.
void use_built_in_name_services() {
  __nss_configure_lookup("hosts", "files dns");
  for (const char* database : {"passwd", "group", "services", "protocols", "networks"})
    __nss_configure_lookup(database, "files");
}

}  // namespace
#endif

int main(int argc, char** argv) {
  using namespace meshgauge::cli;
#ifdef MESHGAUGE_STATIC
  use_built_in_name_services();
#endif
  return run(argc, argv, [argv](CLI::App& app, int& exit_code) {
    add_measuring(app, exit_code);
    add_serving(app, exit_code, argv);
  });
}
