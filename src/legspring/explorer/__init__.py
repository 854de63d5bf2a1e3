"""The explorer: an animal and its gaits in the browser (`legspring explore`).

It computes nothing of its own: `work` asks the package, in processes of their own; `page` shows the answers; `serving`
lets only this machine's browser have them.
"""
