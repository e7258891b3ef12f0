/* Stands in, while linking, for a system library that nobody has. */
__attribute__((visibility("default"))) int gmfbo_absent(void) { return 0; }
