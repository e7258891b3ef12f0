/* What a hostile FMU might try; POSIX and Linux only. */
#ifndef GMFBO_HOSTILE_H
#define GMFBO_HOSTILE_H

/* 1 where it was done, minus the error number where it was refused. */
double attempt(int what);

#endif
