// Part of the statically linked program alone.
#include <openssl/crypto.h>

namespace {

// Keeps OpenSSL from reading openssl.cnf: providers that it names are shared libraries, which crash a static program
// whose glibc is not the machine's. Runs before all static objects, of which cpp-httplib has one that starts OpenSSL.
[[gnu::constructor(101)]] void read_no_openssl_config() { OPENSSL_init_crypto(OPENSSL_INIT_NO_LOAD_CONFIG, nullptr); }

}  // namespace
