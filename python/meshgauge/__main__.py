from meshgauge._command import main

main()
