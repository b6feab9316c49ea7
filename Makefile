# make && sudo make install [prefix=/usr/local] [libdir=…] [DESTDIR=…]; make uninstall with the same variables.
# What is built and where it goes is in scripts/install; docs/installing.md describes it.
export prefix libdir zshdir DESTDIR

build install uninstall:
	scripts/install $@

.DEFAULT_GOAL := build
.PHONY: build install uninstall
